"""Measures the figures of the guide's page on the built-in sensor, and writes them into the page.

    python3 benches/guide.py target/release/loopscope              all figures; the networks take most of an hour
    python3 benches/guide.py target/release/loopscope --quick      without the rows of networks
"""

import json
import math
import re
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).parent.parent / "assets/guide/built-in-sensor.md"
ALL, TENTH = [], ["--decimate", "10"]
NO_PAST = ["--look-back", "none"]
EVERY_BLOCK = ["--look-back", "3,8", "--fixed-lag", "--creep", "--play", "--polynomial", "3", "--ridge", "auto"]
# First cell of each row: the arguments of its fits, and its columns (all samples, every tenth).
ROWS = {
    "linear, no past": (NO_PAST, [ALL, TENTH]),
    "linear, squares and products, no past": ([*NO_PAST, "--polynomial", "2"], [ALL, TENTH]),
    "linear + look-back": ([], [ALL, TENTH]),
    "linear + play operators": ([*NO_PAST, "--play", "--ridge", "auto"], [ALL, None]),
    "linear + every block": (EVERY_BLOCK, [ALL, None]),
    "kernel + look-back": (["--regressor", "kernel"], [ALL, TENTH]),
    "network, no past": ([*NO_PAST, "--regressor", "network"], [None, TENTH]),
    "network + look-back": (["--regressor", "network"], [ALL, TENTH]),
    "linear + network, look-back": (["--regressor", "hybrid-network"], [None, TENTH]),
}


def printed(program, *arguments):
    done = subprocess.run([program, *arguments, "--json"], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def force_errors(found):
    return found["test_rmse"][:3]


def row(program, name):
    arguments, columns = ROWS[name]
    cells = []
    for column in columns:
        if column is None:
            cells.append("")
            continue
        found = printed(program, "fit", *arguments, *column)
        cells.append(", ".join(f"{error:.3f}" for error in force_errors(found["compensated"])) + " N")
    return f"| {name} | {' | '.join(cells)} |".replace("|  |", "| |")


def sentences(program):
    """Returns a pattern and its new text for each sentence with figures of a sweep over the thresholds."""
    found = printed(program, "sweep", "--f-th", "0.5:6:0.5", "--t-th", "1,10,15")
    error = {(point["f_th"], point["t_th"]): math.hypot(*force_errors(point)) for point in found["points"]}
    best = min((at for at in error if at[1] == 15), key=error.get)[0]
    width = found["mean_hysteresis"]
    return {
        r"is least at [\d.]+ N": f"is least at {best:g} N",
        r"recordings is [\d.]+ N over \d+ reversals": f"recordings is {width['value']:.2f} N over {width['n_reversals']} reversals",
        r"falls from [\d.]+ N at 1 s to [\d.]+ N": f"falls from {error[3, 1]:.3f} N at 1 s to {error[3, 10]:.3f} N",
    }


def main():
    program, quick = sys.argv[1], "--quick" in sys.argv
    page = PAGE.read_text()
    new = {rf"\| {re.escape(name)} \|.*": row(program, name) for name in ROWS if not (quick and "network" in name)}
    for pattern, text in {**new, **sentences(program)}.items():
        page, count = re.subn(pattern, lambda _: text, page)
        if count != 1:
            sys.exit(f"{PAGE}: {count} places match {pattern}, not one; edit the page or the script")
    PAGE.write_text(page)


main()
