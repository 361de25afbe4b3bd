# The self-test: runs the calibration on the samples of ../expected.csv and compares the loads. Ends with 0 if all agree.
import csv
import importlib.util
import pathlib
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
FULL_SCALE = np.array([{{ full_scale|join(', ') }}])
ALLOWED = {{ allowed_double }}

spec = importlib.util.spec_from_file_location("calibration", HERE / "{{ name }}.py")
calibration = importlib.util.module_from_spec(spec)
spec.loader.exec_module(calibration)

with open(HERE.parent / "expected.csv", newline="") as file:
    rows = np.array([[float(text) for text in row] for row in list(csv.reader(file))[1:]])
times, gauges,{{ ' auxiliary,' if auxiliary }} loads, conventional, statuses, at_edge = np.split(
    rows, np.cumsum([1, calibration.GAUGES,{{ ' calibration.AUXILIARY,' if auxiliary }} calibration.AXES, calibration.AXES, 1]), axis=1)

state = calibration.State()
worst, compared, bad = 0.0, 0, 0
for k in range(len(rows)):
    actual = state.update(times[k, 0], gauges[k]{{ ', auxiliary[k]' if auxiliary }})
    if at_edge[k, 0] > 0:
        continue
    compared += 1
    off = np.abs(np.array(actual) - [loads[k], conventional[k]]) / FULL_SCALE
    is_rejected = statuses[k, 0] >= calibration.REJECTED_TIME
    off = 0.0 if is_rejected and np.all(np.isnan(actual)) else float(np.max(off))
    worst = max(worst, off)
    if not off <= ALLOWED or state.status != statuses[k, 0]:
        if bad == 0:
            print(f"line {k + 2}: error {off:g} of full scale, status {state.status} instead of {statuses[k, 0]:g}")
        bad += 1
print(f"{'FAIL' if bad else 'PASS'}: {compared} of {len(rows)} samples compared, {bad} differ; "
      f"largest difference {worst:g} of full scale, {ALLOWED:g} allowed")
sys.exit(1 if bad else 0)
