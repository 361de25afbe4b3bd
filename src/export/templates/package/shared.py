# The self-test of the shared library: calls its functions by ctypes on the samples of ../expected.csv and compares the loads.
#
#     cmake -B build && cmake --build build && python3 python/shared.py build/lib{{ name }}_calibration.so
import csv
import ctypes
import math
import pathlib
import sys

N_GAUGES, N_AUXILIARY, N_AXES = {{ n_gauges }}, {{ n_auxiliary }}, {{ n_axes }}
FULL_SCALE = [{{ full_scale|join(', ') }}]
ALLOWED = float(sys.argv[2]) if len(sys.argv) > 2 else {{ allowed_double }}
DOUBLES = ctypes.POINTER(ctypes.c_double)

library = ctypes.CDLL(str(pathlib.Path(sys.argv[1]).resolve()))
create, update = library.{{ name }}_sensor_create, library.{{ name }}_sensor_update
tare, reset, destroy = library.{{ name }}_sensor_tare, library.{{ name }}_sensor_reset, library.{{ name }}_sensor_destroy
create.restype = ctypes.c_void_p
update.argtypes = [ctypes.c_void_p, ctypes.c_double, DOUBLES, DOUBLES, DOUBLES, DOUBLES]
tare.argtypes = [ctypes.c_void_p, DOUBLES]
reset.argtypes = destroy.argtypes = [ctypes.c_void_p]
reset.restype = destroy.restype = None


def numbers(values):
    return (ctypes.c_double * max(1, len(values)))(*values)


def answer(sensor, time, gauges, auxiliary):
    load, conventional = numbers([0.0] * N_AXES), numbers([0.0] * N_AXES)
    status = update(sensor, time, numbers(gauges), numbers(auxiliary), load, conventional)
    return status, [*load, *conventional]


def difference(actual, expected, scale):
    if math.isnan(actual) or math.isnan(expected):
        return 0.0 if math.isnan(actual) and math.isnan(expected) else math.inf
    return abs(actual - expected) / scale


with open(pathlib.Path(__file__).resolve().parent.parent / "expected.csv", newline="") as file:
    rows = [[float(text) for text in row] for row in list(csv.reader(file))[1:]]

sensor = create()
worst, compared, bad = 0.0, 0, 0
# The second run follows a tare and a reset, which must leave no trace.
for _ in range(2):
    for number, row in enumerate(rows):
        inputs = row[1 : 1 + N_GAUGES + N_AUXILIARY]
        status, loads = answer(sensor, row[0], inputs[:N_GAUGES], inputs[N_GAUGES:])
        expected = row[1 + len(inputs) :]
        if expected[2 * N_AXES + 1] > 0:
            continue
        compared += 1
        off = max(map(difference, loads, expected, FULL_SCALE * 2))
        worst = max(worst, off)
        if off > ALLOWED or status != expected[2 * N_AXES]:
            if bad == 0:
                print(f"line {number + 2}: error {off:g} of full scale, status {status} instead of {expected[2 * N_AXES]:g}")
            bad += 1
    bad += tare(sensor, numbers([1.0] * N_GAUGES)) != 0
    bad += tare(sensor, numbers([math.nan] * N_GAUGES)) != -1
    reset(sensor)
destroy(sensor)
print(f"{'FAIL' if bad else 'PASS'}: {compared} of {2 * len(rows)} samples compared, {bad} differ; "
      f"largest difference {worst:g} of full scale, {ALLOWED:g} allowed")
sys.exit(1 if bad else 0)
