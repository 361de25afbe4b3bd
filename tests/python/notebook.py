"""Runs the lines of the guide page, and compares their result with the program's. The first argument is the page."""

import pathlib
import re
import sys

page = pathlib.Path(sys.argv[1]).read_text(encoding="utf-8")
lines = re.search(r"```python\n(.*?)```", page, re.DOTALL)[1]
assert len([line for line in lines.splitlines() if line.strip()]) == 10
exec(lines)
import loopscope

assert loopscope.program().startswith(sys.prefix), loopscope.program()
assert pathlib.Path("sensor.h").stat().st_size > 1000 and pathlib.Path("sensor.py").exists()
assert len(cal.errors["compensated test"]) == 6
assert (cal.errors["compensated test"] < cal.errors["uncompensated test"]).all()
assert len(loads["t [s]"]) == len(next(iter(test.values()))["t [s]"])
