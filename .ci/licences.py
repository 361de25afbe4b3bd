#!/usr/bin/env python3
"""Writes assets/licences.txt: every crate that is linked into the program on Linux, Windows or macOS, its copyright lines and
its licence texts, each text once; and what only builds or tests it. A test holds the lists to Cargo.lock.

    python3 .ci/licences.py        (after a change of Cargo.lock; Python 3.8 or newer, nothing else)
"""

import json
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NAMES = re.compile(r"^(licen[cs]e|copying|copyright|notice|unlicense|ofl|ufl)", re.IGNORECASE)
SOURCES = {".rs", ".py", ".sh", ".html", ".json", ".toml", ".hbs"}
COPYRIGHT = re.compile(r"^[\s#*/-]*(copyright\s*(\(c\)|©|:|[0-9])|\(c\)\s+[0-9]|©)", re.IGNORECASE)
# Placeholders of the Apache licence's appendix name nobody.
PLACEHOLDER = re.compile(r"yyyy|name of (copyright )?owner|\{year\}|<year>", re.IGNORECASE)
SYSTEMS = ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu", "x86_64-pc-windows-msvc", "x86_64-apple-darwin", "aarch64-apple-darwin"]
# What is offered under several licences is taken under the one that asks for no more than its notice.
NOT_TAKEN = re.compile(r"GNU GENERAL PUBLIC LICENSE|GNU LESSER GENERAL PUBLIC LICENSE")


# The Apache licence is one text, however it is indented; what a crate adds to it stands after its end.
APACHE = re.compile(r"^\s*Apache License\s+Version 2\.0, January 2004\s.*?END OF TERMS AND CONDITIONS", re.DOTALL)
APPENDIX = re.compile(r"^\s*APPENDIX: How to apply the Apache License.*?limitations under the License\.?\s*", re.DOTALL)


def metadata_of(*arguments):
    command = ["cargo", "metadata", "--locked", "--format-version", "1", *arguments]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)


def linked(metadata):
    """The ids of all crates that are in the program: by what is neither for building nor for testing."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    root = metadata["resolve"]["root"]
    found, left = set(), [root]
    while left:
        crate = left.pop()
        if crate in found:
            continue
        found.add(crate)
        for dependency in nodes[crate]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                left.append(dependency["pkg"])
    return found - {root}


def texts_of(package):
    """The crate's licence files: its copyright lines, and the texts without them."""
    folder = Path(package["manifest_path"]).parent
    files = [path for path in folder.rglob("*")
             if path.is_file() and NAMES.match(path.name) and path.suffix.lower() not in SOURCES]
    copyrights, texts = [], []
    for path in sorted(files):
        text = path.read_text(encoding="utf-8", errors="replace")
        if NOT_TAKEN.search(text):
            continue
        kept = []
        for line in text.splitlines():
            if COPYRIGHT.match(line) and not PLACEHOLDER.search(line):
                line = " ".join(line.split()).strip("#*/- ")
                if line not in copyrights:
                    copyrights.append(line)
            else:
                kept.append(line.rstrip())
        body = "\n".join(kept).strip("\n")
        if apache := APACHE.match(body):
            texts.append(APACHE.match((ROOT / "LICENSE-APACHE").read_text(encoding="utf-8")).group())
            body = APPENDIX.sub("", body[apache.end():])
        if body.strip():
            texts.append(body.strip("\n"))
    return copyrights, texts


def main():
    metadata = metadata_of()
    inside = set().union(*(linked(metadata_of("--filter-platform", system)) for system in SYSTEMS))
    packages = [package for package in metadata["packages"] if package["id"] != metadata["resolve"]["root"]]
    packages.sort(key=lambda package: (package["name"], package["version"]))
    numbers, bodies, lines = {}, [], []
    for package in packages:
        if package["id"] not in inside:
            continue
        copyrights, texts = texts_of(package)
        own = set()
        for text in texts:
            key = re.sub(r"[^a-z0-9]+", "", text.lower())
            if key not in numbers:
                numbers[key] = len(bodies) + 1
                bodies.append(text)
            own.add(numbers[key])
        said = package["license"] or "see its text"
        named = " ".join(f"[{number}]" for number in sorted(own))
        lines.append(f"{package['name']} {package['version']}: {said} {named}".rstrip())
        if package["repository"]:
            lines.append(f"    {package['repository']}")
        if not copyrights and package["authors"]:
            copyrights = ["by " + ", ".join(package["authors"])]
        lines += [f"    {line}" for line in copyrights]
    others = [f"{package['name']} {package['version']}" for package in packages if package["id"] not in inside]
    out = ["Crates in this program on Linux, Windows and macOS. A number in brackets is a text below;",
           "a crate without one ships no text of its own, and that of its licence's name applies.", ""]
    out += lines
    out += ["", "Only used to build or to test it, or not on these systems:", ""]
    out += others
    for number, body in enumerate(bodies, 1):
        out += ["", f"==== [{number}] ====", "", body]
    (ROOT / "assets/licences.txt").write_text("\n".join(out) + "\n", encoding="utf-8")


main()
