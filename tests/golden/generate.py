"""Makes the recordings in this folder, and expected.json with the errors and loads of their calibrations. Needs NumPy. Run in this
folder: python3 generate.py

The implementation is plain and shares no code with the program: a backward scan for past samples, complete design matrices, least
squares by numpy.linalg.lstsq, and cross-validation by a new fit without the left-out part.
"""

import json
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
FORCES = ("Fx", "Fy", "Fz")
BLOCKS = 5


# ---------------------------------------------------------------------------------------------------- simulated sensors


def play(signal, radius):
    """Returns the play operator: a value that changes only when the signal is more than the radius away."""
    out = np.empty_like(signal)
    state = signal[0]
    for k, value in enumerate(signal):
        state = min(max(state, value - radius), value + radius)
        out[k] = state
    return out


def sensor(rng, load, mixing, offsets, scales):
    """Returns gauges that measure a mixture of the loads with a square term and hysteresis. Each has its own offset and scale."""
    gauges = np.empty((len(load), len(offsets)))
    for g, (offset, scale) in enumerate(zip(offsets, scales)):
        strain = load @ mixing[:, g]
        strain = strain + 0.02 * strain**2
        spread = np.abs(mixing[:, g]).sum()
        bent = strain + 0.25 * play(strain, 0.3 * spread) + 0.002 * rng.standard_normal(len(strain))
        gauges[:, g] = offset + scale * bent
    return gauges


def jittered_times(rng, n, rate, start):
    """Returns increasing times with jitter, on average `rate` samples per second."""
    return start + (np.arange(n) + rng.uniform(0.0, 0.6, n)) / rate


def motion(rng, times, full_scales, slowest, fastest):
    """Returns loads that are a sum of four sines for each axis."""
    load = np.zeros((len(times), len(full_scales)))
    for axis, full_scale in enumerate(full_scales):
        for _ in range(4):
            rate, phase = rng.uniform(slowest, fastest), rng.uniform(0.0, 2.0 * np.pi)
            load[:, axis] += 0.4 * full_scale * np.sin(2.0 * np.pi * rate * times + phase)
    return load


def write(name, header, times, gauges, load, digits):
    """Writes a recording with few digits, so that the file is small. The expected results are computed from the written numbers."""
    with open(HERE / name, "w") as out:
        out.write(header + "\n")
        for time, row, truth in zip(times, gauges, load):
            cells = [f"{time:.4f}"] + [f"{value:.{digits}g}" for value in row] + [f"{value:.5g}" for value in truth]
            out.write(",".join(cells) + "\n")


def write_eight_gauges():
    """Writes recordings at 100 Hz with six axes. The gauges have units from microvolts to counts, and offsets far above their signal."""
    rng = np.random.default_rng(20)
    full_scales = (40.0, 30.0, 90.0, 2.0, 1.5, 0.8)
    mixing = rng.normal(size=(6, 8)) / np.array(full_scales)[:, None]
    offsets = (52000.0, -310.0, 2.5, -0.004, 7.0e5, 12.0, -9.0, 0.0)
    scales = (900.0, 20.0, 0.3, 0.001, 4000.0, 5.0, 0.02, 1.0)
    header = "t [s],S1,S2,S3,S4,S5,S6,S7,S8,Fx [N],Fy [N],Fz [N],Mx [N·m],My [N·m],Mz [N·m]"
    for name, n, start in (("train_1", 340, 0.0), ("train_2", 300, 17.0), ("train_3", 381, 5.5), ("test_1", 310, 2.0)):
        times = jittered_times(rng, n, 100.0, start)
        load = motion(rng, times, full_scales, 0.1, 1.5)
        write(f"eight_gauges_{name}.csv", header, times, sensor(rng, load, mixing, offsets, scales), load, 9)


def write_two_gauges():
    """Writes one recording at 12 Hz with one force."""
    rng = np.random.default_rng(21)
    times = jittered_times(rng, 731, 12.0, 0.0)
    load = motion(rng, times, (5.0,), 0.02, 0.4)
    gauges = sensor(rng, load, np.array([[0.2, -0.15]]), (37000.0, 1100.0), (5200.0, 90.0))
    write("two_gauges.csv", "t [s],u1,u2,Fz [N]", times, gauges, load, 9)


def write_even_clock():
    """Writes a recording at exactly 8 Hz. The age of many samples is exactly t_th, which is still allowed."""
    rng = np.random.default_rng(23)
    times = np.arange(170) / 8.0
    load = motion(rng, times, (8.0, 12.0), 0.1, 0.9)
    gauges = sensor(rng, load, np.array([[0.1, -0.02, 0.05], [0.03, 0.08, 0.06]]), (0.0, 1.0, 2.0), (1.0, 1.0, 1.0))
    write("even_clock.csv", "t [s],SG0,SG1,SG2,Fx [N],Fz [N]", times, gauges, load, 8)


def write_moment_only():
    """Writes recordings without a force axis, so the distance of the look-back is a share of full scale. One of the four gauges is constant."""
    rng = np.random.default_rng(22)
    mixing = np.array([[0.5, -0.4, 0.3, 0.0]])
    for name, n in (("train_1", 210), ("train_2", 180), ("train_3", 240), ("train_4", 150), ("test_1", 200)):
        times = jittered_times(rng, n, 25.0, 100.0)
        load = motion(rng, times, (2.0,), 0.05, 0.8)
        gauges = sensor(rng, load, mixing, (3.0, -1.0, 0.2, 0.0), (1.0, 0.8, 1.5, 1.0))
        gauges[:, 3] = 0.25
        write(f"moment_only_{name}.csv", "t [s],ch0,ch1,ch2,ch3,My [N·m]", times, gauges, load, 8)


# ----------------------------------------------------------------------------------------------------------- the method


def read(name):
    """Returns times, gauges, load and axes of a file."""
    header = (HERE / name).read_text().split("\n", 1)[0].split(",")
    axes = [cell[:2] for cell in header if cell[:2] in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
    table = np.loadtxt(HERE / name, delimiter=",", skiprows=1)
    return table[:, 0], table[:, 1 : -len(axes)], table[:, -len(axes) :], axes


def least_squares(design, target):
    """Returns the solution of least norm on columns of unit length, so that the unit of a gauge has no effect."""
    lengths = np.linalg.norm(design, axis=0)
    lengths[lengths == 0.0] = 1.0
    return np.linalg.lstsq(design / lengths, target, rcond=None)[0] / lengths[:, None]


def with_offset(columns, offset):
    return np.hstack([columns, np.ones((len(columns), 1))]) if offset else columns


def past_samples(times, conventional, weights, f_th, t_th):
    """Returns the past sample of each sample k: going back from k, the first sample whose conventional load differs by F_th. If none within
    t_th does, returns k."""
    past = []
    for k in range(len(times)):
        found = k
        for j in range(k, -1, -1):
            if times[k] - times[j] > t_th:
                break
            if np.sqrt(np.sum((weights * (conventional[k] - conventional[j])) ** 2)) >= f_th:
                found = j
                break
        past.append(found)
    return np.array(past)


def rmse(errors):
    return np.sqrt(np.mean(errors**2, axis=0))


def left_out_folds(lengths):
    """Returns the samples that are left out together: whole recordings, or with fewer than three recordings five contiguous blocks."""
    samples = np.arange(sum(lengths))
    if len(lengths) >= 3:
        return np.split(samples, np.cumsum(lengths)[:-1])
    return np.array_split(samples, BLOCKS)


def left_out(designs, targets, cold=None):
    """Returns the errors of every training sample, predicted by a fit without the fold of the sample. `cold(samples)` returns the rows of
    samples as after a cold start: earlier samples are unknown. All fits and errors use these rows."""
    design, target = np.vstack(designs), np.vstack(targets)
    errors = np.empty_like(target)
    folds = left_out_folds([len(one) for one in designs])
    if cold:
        design = np.vstack([cold(fold) for fold in folds])
    for fold in folds:
        rest = np.setdiff1d(np.arange(len(design)), fold)
        errors[fold] = design[fold] @ least_squares(design[rest], target[rest]) - target[fold]
    return errors


def rank_and_condition(gauges, past_gauges, offset):
    """Returns rank and condition of the columns [z, z_past - z, 1], each of unit length. z are the gauges minus their mean, or without an
    offset the gauges."""
    z = gauges - gauges.mean(axis=0) if offset else gauges
    z = np.where(np.ptp(gauges, axis=0) > 0.0, z, 0.0 if offset else z)
    columns = with_offset(np.hstack([z, past_gauges - gauges]), offset)
    lengths = np.linalg.norm(columns, axis=0)
    columns = columns[:, lengths > 0.0] / lengths[lengths > 0.0]
    values = np.linalg.svd(columns, compute_uv=False)
    rank = int(np.sum(values > 1e-9 * values[0]))
    return rank, values[0] / values[rank - 1]


def full_scale_of(loads):
    """Returns half the peak-to-peak load of each axis, or its largest magnitude if the load has one direction."""
    up, down = np.maximum(loads.max(axis=0), 0.0), np.maximum(-loads.min(axis=0), 0.0)
    one_way = np.minimum(up, down) < 0.1 * np.maximum(up, down)
    return np.where(one_way, np.maximum(up, down), np.ptp(loads, axis=0) / 2.0)


def calibrate(train, test, f_th, t_th, distance, offset=True, decimate=1, split=None, full_scale=None):
    """Returns the numbers that the program reports, and the predicted loads of the test recordings."""
    train, test = [read(name) for name in train], [read(name) for name in test]
    axes = train[0][3]
    train, test = [part[:3] for part in train], [part[:3] for part in test]
    if split is not None:
        cuts = [int(split * len(times)) for times, _, _ in train]
        test = [[column[cut:] for column in part] for part, cut in zip(train, cuts)]
        train = [[column[:cut] for column in part] for part, cut in zip(train, cuts)]
    train = [[column[::decimate] for column in part] for part in train]
    test = [[column[::decimate] for column in part] for part in test]

    truth = np.vstack([load for _, _, load in train])
    if full_scale is None:
        full_scale = full_scale_of(truth)
    if distance == "force":
        weights = np.array([1.0 if axis in FORCES else 0.0 for axis in axes])
    else:
        weights = 1.0 / np.array(full_scale)

    present = [with_offset(gauges, offset) for _, gauges, _ in train]
    conventional = least_squares(np.vstack(present), truth)

    def history(part):
        times, gauges, _ = part
        loads = with_offset(gauges, offset) @ conventional
        past = past_samples(times, loads, weights, f_th, t_th)
        return loads, past, with_offset(np.hstack([gauges, gauges[past]]), offset)

    train_history, test_history = [history(part) for part in train], [history(part) for part in test]
    designs = [design for _, _, design in train_history]
    targets = [load for _, _, load in train]
    compensated = least_squares(np.vstack(designs), truth)

    n_gauges = train[0][1].shape[1]
    all_gauges = np.vstack([gauges for _, gauges, _ in train])
    starts = np.cumsum([0] + [len(times) for times, _, _ in train[:-1]])
    all_past = np.concatenate([start + past for start, (_, past, _) in zip(starts, train_history)])

    def cold(fold):
        past = np.where(all_past[fold] < fold[0], fold, all_past[fold])
        return with_offset(np.hstack([all_gauges[fold], all_gauges[past]]), offset)

    all_designs = np.vstack(designs)
    rank, condition = rank_and_condition(all_designs[:, :n_gauges], all_designs[:, n_gauges : 2 * n_gauges], offset)
    report = {
        "n_train": len(truth),
        "n_test": sum(len(times) for times, _, _ in test),
        "axes": axes,
        "full_scale": [float(value) for value in full_scale],
        "rank": rank,
        "condition": float(condition),
        "conventional": {
            "train_rmse": rmse(np.vstack(present) @ conventional - truth).tolist(),
            "cv_rmse": rmse(left_out(present, targets)).tolist(),
        },
        "compensated": {
            "train_rmse": rmse(all_designs @ compensated - truth).tolist(),
            "cv_rmse": rmse(left_out(designs, targets, cold)).tolist(),
        },
    }
    loads = None
    if test:
        truth = np.vstack([load for _, _, load in test])
        conv = np.vstack([loads for loads, _, _ in test_history])
        comp = np.vstack([design @ compensated for _, _, design in test_history])
        report["conventional"]["test_rmse"] = rmse(conv - truth).tolist()
        report["compensated"]["test_rmse"] = rmse(comp - truth).tolist()
        loads = (conv, comp)
    return report, loads


# ------------------------------------------------------------------------------------------------------------ the cases


def arguments(train, test, f_th, t_th, distance, offset=True, decimate=1, split=None, full_scale=None):
    """Returns these settings as command-line arguments."""
    words = ["--train", *train] + (["--test", *test] if test else [])
    words += ["--f-th", repr(f_th), "--t-th", repr(t_th), "--distance", distance]
    words += [] if offset else ["--no-offset"]
    words += ["--decimate", str(decimate)] if decimate > 1 else []
    words += ["--split", repr(split)] if split is not None else []
    words += ["--full-scale", ",".join(repr(value) for value in full_scale)] if full_scale else []
    return words


def cases():
    """Yields the sensor and the settings of every fit."""
    train = [f"eight_gauges_train_{k}.csv" for k in (1, 2, 3)]
    test = ["eight_gauges_test_1.csv"]
    six = ("eight_gauges", dict(train=train, test=test, distance="force", f_th=25.0, t_th=1.5))
    for change in (
        dict(),
        dict(f_th=0.0),
        dict(f_th=4.0),
        dict(f_th=80.0, t_th=3.0),
        dict(f_th=1e9),
        dict(t_th=0.0),
        dict(t_th=0.05),
        dict(offset=False),
        dict(decimate=3),
        dict(distance="full-scale", f_th=0.5),
        dict(distance="full-scale", f_th=0.5, full_scale=[50.0, 50.0, 100.0, 2.0, 2.0, 1.0]),
        dict(train=train[:2]),
        dict(train=train[:1], offset=False),
        dict(test=[]),
        dict(test=[], split=0.7, decimate=2),
    ):
        yield six[0], six[1] | change
    one = ("two_gauges", dict(train=["two_gauges.csv"], test=[], split=0.6, distance="force", f_th=2.0, t_th=15.0))
    for change in (
        dict(),
        dict(f_th=0.0),
        dict(f_th=0.3, t_th=3.0),
        dict(f_th=1e9),
        dict(offset=False),
        dict(split=0.333, decimate=2),
        dict(split=None),
        dict(distance="full-scale", f_th=0.25),
    ):
        yield one[0], one[1] | change
    even = ("even_clock", dict(train=["even_clock.csv"], test=[], split=0.75, distance="force", f_th=5.0, t_th=0.5))
    for change in (dict(), dict(t_th=0.125, f_th=1.0), dict(t_th=1.0, decimate=4)):
        yield even[0], even[1] | change
    train = [f"moment_only_train_{k}.csv" for k in (1, 2, 3, 4)]
    test = ["moment_only_test_1.csv"]
    moment = ("moment_only", dict(train=train, test=test, distance="full-scale", f_th=0.25, t_th=4.0))
    for change in (
        dict(),
        dict(f_th=0.0),
        dict(f_th=0.8, t_th=8.0),
        dict(f_th=9.0),
        dict(offset=False),
        dict(full_scale=[5.0]),
        dict(decimate=5),
    ):
        yield moment[0], moment[1] | change


def applied(sensor, choices, samples):
    """Returns the loads of some samples of the test recording."""
    _, (conventional, compensated) = calibrate(**choices)
    rows = [
        {"sample": k, "conventional": conventional[k].tolist(), "compensated": compensated[k].tolist()} for k in samples
    ]
    return {"sensor": sensor, "fit": arguments(**choices), "file": choices["test"][0], "rows": rows}


def main():
    write_eight_gauges()
    write_two_gauges()
    write_even_clock()
    write_moment_only()
    fits = []
    loads = []
    for sensor, choices in cases():
        report, _ = calibrate(**choices)
        fits.append({"sensor": sensor, "arguments": arguments(**choices), "expected": report})
        # A decimated calibration is applied to all samples, which have another history. So it is left out here.
        if choices["test"] and choices["f_th"] in (25.0, 0.25, 0.5) and "decimate" not in choices:
            loads.append(applied(sensor, choices, (0, 3, 41, 199)))
    text = json.dumps({"fits": fits, "applied": loads}, indent=1)
    (HERE / "expected.json").write_text(text + "\n")


if __name__ == "__main__":
    main()
