"""Measures all figures of the guide's page on the built-in sensor, and writes the figures into this page.

    python3 benches/guide.py target/release/loopscope              all figures; the networks take most of an hour
    python3 benches/guide.py target/release/loopscope --quick      without networks
"""

import functools
import html
import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

PAGE = Path(__file__).parent.parent / "assets/guide/built-in-sensor.md"
ALL, TENTH = [], ["--decimate", "10"]
NO_PAST = ["--look-back", "none"]
NETWORK, HYBRID = ["--regressor", "network"], ["--regressor", "hybrid-network"]
PLAY = ["--look-back", "3", "--play", "--ridge", "auto"]
FEW_EPOCHS = [*TENTH, "--epochs", "400"]
EVERY_BLOCK = ["--look-back", "3,8", "--fixed-lag", "--creep", "--play", "--polynomial", "3", "--ridge", "auto"]
# First cell of each table row: the arguments of its fits, and the arguments of its two columns (all samples, every tenth sample).
ROWS = {
    "linear, no past": (NO_PAST, [ALL, TENTH]),
    "linear, squares and products, no past": ([*NO_PAST, "--polynomial", "2"], [ALL, TENTH]),
    "linear + look-back": ([], [ALL, TENTH]),
    "linear + play operators": ([*NO_PAST, "--play", "--ridge", "auto"], [ALL, None]),
    "linear + every block": (EVERY_BLOCK, [ALL, None]),
    "kernel + look-back": (["--regressor", "kernel"], [ALL, TENTH]),
    "network, no past": ([*NO_PAST, *NETWORK], [None, TENTH]),
    "network + look-back": (NETWORK, [ALL, TENTH]),
    "linear + network, look-back": (HYBRID, [None, TENTH]),
}
FORCES = "#, #, # N"


class Page:
    """Text of the guide's page, and the program that measures the figures."""

    def __init__(self, program):
        self.program = program
        self.text = PAGE.read_text()

    def fill(self, template, *values):
        """Replaces the numbers in the text that matches the template, where # stands for a number. The text must match exactly once."""
        pieces = [r"\s+".join(map(re.escape, piece.split(" "))) for piece in template.split("#")]
        found = list(re.finditer(r"(-?\d[\d.]*)".join(pieces), self.text))
        if len(found) != 1 or len(pieces) != len(values) + 1:
            sys.exit(f"{PAGE}: {len(found)} places read like {template!r}, not one; edit the page or the script")
        for at, value in reversed(list(enumerate(values, 1))):
            start, end = found[0].span(at)
            self.text = self.text[:start] + value + self.text[end:]

    @functools.cache
    def printed(self, *arguments):
        done = subprocess.run([self.program, *arguments, "--json"], check=True, capture_output=True, text=True)
        return json.loads(done.stdout)

    def forces(self, *arguments, scores="test_rmse", of="compensated"):
        """Returns the RMSE of the three forces after a fit with these arguments (N)."""
        return [f"{error:.3f}" for error in self.printed("fit", *arguments)[of][scores][:3]]

    def bench(self, *arguments):
        """Returns the figures of Fx on the bench recordings after a fit with these arguments: uncompensated, compensated (N)."""
        with tempfile.TemporaryDirectory() as folder:
            report = Path(folder) / "report.html"
            subprocess.run([self.program, "report", *arguments, "--out", report], check=True, capture_output=True)
            text = report.read_text()
        figures = {}
        for row in re.findall(r"<tr.*?</tr>", text, re.S):
            name, *cells = [html.unescape(re.sub("<[^>]+>", "", cell)).strip() for cell in re.findall(r"<t[dh].*?</t[dh]>", row, re.S)] or [""]
            if name in ("Repeatability", "Zero return", "Creep", "Largest error") and name not in figures:
                figures[name] = [f"{float(cells[at]):.2f}" for at in (0, 2)]
        return figures

    def rows(self, quick):
        for name, (arguments, columns) in ROWS.items():
            if quick and "network" in name:
                continue
            cells = ["" if column is None else ", ".join(self.forces(*arguments, *column)) + " N" for column in columns]
            row = f"| {name} | {' | '.join(cells)} |".replace("|  |", "| |")
            self.text, count = re.subn(rf"\| {re.escape(name)} \|.*", lambda _: row, self.text)
            if count != 1:
                sys.exit(f"{PAGE}: {count} rows begin with {name!r}, not one")

    def linear_sentences(self):
        uncompensated, compensated = self.forces(of="conventional"), self.forces()
        self.fill(f"the uncompensated load errs by {FORCES} (Fx, Fy, Fz), the compensated load at 3 N and 15 s by {FORCES}", *uncompensated, *compensated)
        found = self.printed("sweep", "--f-th", "0.5:6:0.5", "--t-th", "1,10,15")
        error = {(point["f_th"], point["t_th"]): math.hypot(*point["test_rmse"][:3]) for point in found["points"]}
        best = min((at for at in error if at[1] == 15), key=error.get)[0]
        width = found["mean_hysteresis"]
        self.fill("is lowest at # N", f"{best:g}")
        self.fill("recordings is # N (# reversals)", f"{width['value']:.2f}", str(width["n_reversals"]))
        self.fill("falls from # N at 1 s to # N", f"{error[3, 1]:.3f}", f"{error[3, 10]:.3f}")

    def bench_sentences(self):
        usual, longer, play = self.bench(), self.bench("--t-th", "200"), self.bench(*PLAY)
        three = "Repeatability", "Creep", "Largest error"
        self.fill("repeatability # → # N, creep # → # N, largest error # → # N", *[value for name in three for value in usual[name]])
        self.fill("creep # N and zero return # → # N are smaller", longer["Creep"][1], *longer["Zero return"])
        tests = self.forces(*PLAY)
        self.fill(f"the three figures of Fx are #, # and # N, and the test errors {FORCES}", *[play[name][1] for name in three], *tests)

    def network_sentences(self):
        self.fill(f"on the training paths it has {FORCES}.", *self.forces(*NETWORK, scores="train_rmse"))
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([self.program, "demo", folder], check=True, capture_output=True)
            files = ["--train", *sorted(map(str, Path(folder).glob("train_path1_*"))), "--test", *sorted(map(str, Path(folder).glob("test_*")))]
            few = [self.forces(*FEW_EPOCHS, *regressor, *files) for regressor in ([], NETWORK, HYBRID)]
        template = f"has {FORCES} on the test recordings, the network with look-back {FORCES}, the hybrid {FORCES}."
        self.fill(template, *few[0], *few[1], *few[2])
        template = f"the network with look-back (400 epochs) has {FORCES} against {FORCES}"
        self.fill(template, *self.forces(*FEW_EPOCHS, *NETWORK), *self.forces(*TENTH))


def main():
    page, quick = Page(sys.argv[1]), "--quick" in sys.argv
    page.linear_sentences()
    page.bench_sentences()
    page.rows(quick)
    if not quick:
        page.network_sentences()
    PAGE.write_text(page.text)


main()
