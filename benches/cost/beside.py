"""Times one slider step in NumPy, to compare it with `cargo bench --bench cost`. A step is the look-back (a plain loop compiled from C),
the columns [S, S_past], normal equations, and the RMSE of all samples. It has neither cross-validation nor plots.

    python3 benches/cost/beside.py 100000 1000000          recordings with the sizes of that bench, at 1 kHz
    python3 benches/cost/beside.py --rate 20 243000        at the sample rate of the built-in sensor
"""

import ctypes
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy

SEARCH = r"""
#include <stddef.h>
void past(size_t n, const double *t, const double *f, double f_th, double t_th, long *out) {
    for (size_t k = 0; k < n; k++) {
        out[k] = k;
        for (size_t j = k + 1; j-- > 0 && t[k] - t[j] <= t_th;) {
            double x = f[3 * k] - f[3 * j], y = f[3 * k + 1] - f[3 * j + 1], z = f[3 * k + 2] - f[3 * j + 2];
            if (x * x + y * y + z * z >= f_th * f_th) { out[k] = j; break; }
        }
    }
}
"""


def compiled():
    folder = Path(tempfile.mkdtemp())
    (folder / "past.c").write_text(SEARCH)
    subprocess.run(["cc", "-O3", "-march=native", "-shared", "-fPIC", "-o", folder / "past.so", folder / "past.c"], check=True)
    past = ctypes.CDLL(str(folder / "past.so")).past
    table = numpy.ctypeslib.ndpointer(dtype=float, flags="C")
    past.argtypes = [ctypes.c_size_t, table, table, ctypes.c_double, ctypes.c_double,
                     numpy.ctypeslib.ndpointer(dtype=numpy.int64, flags="C")]
    past.restype = None
    return past


def recording(n, rate):
    k = numpy.arange(n)
    t = k / rate
    waves = [numpy.sin(t * (0.3 + 0.01 * phase)) + ((k * 7 + phase * 13) % 101) * 1e-3 for phase in range(6)]
    gauges = numpy.stack(waves, axis=1)
    return t, gauges, 10 * gauges


def step(past, t, gauges, loads, forces, f_th):
    n = len(t)
    began = time.perf_counter()
    found = numpy.empty(n, dtype=numpy.int64)
    past(n, t, forces, f_th, 15.0, found)
    searched = time.perf_counter()
    x = numpy.hstack([gauges, gauges[found], numpy.ones((n, 1))])
    matrix = numpy.linalg.solve(x.T @ x + 1e-9 * numpy.eye(x.shape[1]), x.T @ loads)
    numpy.sqrt(((x @ matrix - loads) ** 2).mean(axis=0))
    ended = time.perf_counter()
    return ended - began, searched - began


def main():
    arguments = sys.argv[1:]
    rate = 1000.0
    if arguments[:1] == ["--rate"]:
        rate, arguments = float(arguments[1]), arguments[2:]
    past = compiled()
    print(f"{'samples':>12} {'step [ms]':>12} {'[ns/sample]':>12} {'search [ms]':>12}")
    for n in map(int, arguments or ["100000", "300000", "1000000", "3000000", "10000000"]):
        t, gauges, loads = recording(n, rate)
        forces = numpy.ascontiguousarray(loads[:, :3])
        whole, search = sorted(step(past, t, gauges, loads, forces, 3 + 0.01 * at) for at in range(3))[1]
        print(f"{n:>12} {1e3 * whole:>12.1f} {1e9 * whole / n:>12.1f} {1e3 * search:>12.1f}", flush=True)


main()
