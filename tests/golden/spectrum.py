"""Writes spectrum.json with the amplitude spectral density of a signal, for the test in src/questions/channels/spectrum.rs. Needs NumPy and SciPy. Run in
this folder: python3 spectrum.py"""

import json

import numpy as np
from scipy.signal import welch

N_SAMPLES = 1234
RATE_HZ = 250.0
SEGMENT = 128

k = np.arange(N_SAMPLES)
signal = 3.0 + 0.01 * k + np.sin(0.9 * k) + 0.2 * np.cos(2.3 * k + 0.001 * k * k)
frequencies, squares = welch(signal, RATE_HZ, window="hann", nperseg=SEGMENT, detrend="constant")
golden = {
    "n_samples": N_SAMPLES,
    "frequencies": frequencies.tolist(),
    "densities": np.sqrt(squares).tolist(),
}
with open("spectrum.json", "w", encoding="utf-8") as out:
    json.dump(golden, out)
    out.write("\n")
