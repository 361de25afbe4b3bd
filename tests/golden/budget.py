"""Makes the folder budget: recordings of made-up sensors, and their error budgets by a plain implementation that shares no code with the
program. It works on samples: every fit is a least-squares fit to all rows of the training units, and every error is summed over
predicted samples. Needs NumPy and SciPy. Run in this folder: python3 budget.py
"""

import itertools
import json
import math
from pathlib import Path

import numpy as np
from scipy.stats import t as student

FOLDER = Path(__file__).parent / "budget"
COLUMN_CAUSES = ["curvature", "hysteresis", "creep", "lag", "temperature"]
UNIT_CAUSES = ["zeros", "drift", "sensitivity"]
RIDGES = [1e-6, 1e-4, 1e-2, 1.0]


# The made-up sensors.


def sums_of_sines(random, n, n_axes, speed):
    """Returns smooth loads on each axis."""
    time = np.arange(n)[:, None]
    rates = speed * random.uniform(0.5, 1.5, (5, n_axes))
    phases = random.uniform(0, 2 * np.pi, (5, n_axes))
    return sum(np.sin(rate * time + phase) for rate, phase in zip(rates, phases)) / 2.5


def backlash(signal, width):
    position, out = signal[0], np.empty_like(signal)
    for k, value in enumerate(signal):
        position = np.clip(position, value - width, value + width)
        out[k] = position
    return out


def late(signal, samples):
    at = np.arange(len(signal)) - samples
    return np.stack([np.interp(at, np.arange(len(signal)), column) for column in signal.T], axis=1)


def sensor(seed, n_recordings, n, n_axes, n_gauges, speed, *, curved=0.0, play=0.0, lag=0.0, zeros=0.0, factors=0.0, warm=0.0, noise=0.0):
    """Returns recordings as (gauges, loads, auxiliary channels) of a sensor with these faults."""
    random = np.random.default_rng(seed)
    matrix = 0.4 * random.normal(size=(n_gauges, n_axes)) + np.eye(n_gauges, n_axes)
    bends, warmth = random.normal(size=n_gauges), random.normal(size=n_gauges)
    recordings = []
    for _ in range(n_recordings):
        loads = sums_of_sines(random, n, n_axes, speed) if speed else random.uniform(-1, 1, (n, n_axes))
        strain = loads @ matrix.T
        gauges = strain + curved * bends * strain**2
        if play:
            gauges = gauges + play * (backlash(strain, 0.4) - strain)
        if lag:
            gauges = late(gauges, lag)
        gauges = gauges * (1 + factors * random.normal())
        temperature = 25 + np.cumsum(random.normal(size=(n, 1)), axis=0) / np.sqrt(n) + random.normal()
        gauges = gauges + warm * (temperature - 25) * warmth + zeros * random.normal(size=n_gauges)
        gauges = gauges + noise * random.normal(size=gauges.shape)
        recordings.append((gauges, loads, temperature if warm else np.empty((n, 0))))
    return recordings


SENSORS = {
    "curved": sensor(1, 4, 500, 2, 3, 0.03, curved=0.03, lag=0.8, zeros=0.03, noise=0.004),
    "hysteretic": sensor(2, 1, 1100, 1, 1, 0.04, play=0.15, noise=0.01),
    "two": sensor(3, 2, 500, 1, 2, 0.04, play=0.1, curved=0.05, noise=0.01),
    "poses": sensor(4, 5, 40, 3, 3, 0.0, curved=0.05, factors=0.05, noise=0.01),
    "warm": sensor(5, 12, 130, 2, 2, 0.1, warm=0.05, factors=0.06, noise=0.01),
    "many": sensor(6, 3, 400, 1, 10, 0.05, play=0.2, noise=0.02),
    "coarse": sensor(7, 4, 150, 1, 2, 0.6, curved=0.1, lag=0.3, noise=0.005),
}


def written(name, recordings):
    """Writes the recordings and returns their values as they are written."""
    out = []
    for number, parts in enumerate(recordings, 1):
        values = np.concatenate(parts, axis=1)
        heads = [f"{letter}{k + 1}" for letter, part in zip("SFT", parts) for k in range(part.shape[1])]
        path = FOLDER / f"{name}_{number}.csv"
        np.savetxt(path, values, "%.7g", ",", header=",".join(heads), comments="")
        values = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
        out.append(np.split(values, np.cumsum([part.shape[1] for part in parts])[:2], axis=1))
    return out


# The time scale of the load.


def mean_change(loads, interval, longer):
    changes = [np.mean((load[interval:] - load[:-interval]) ** 2, axis=0) for load in loads if len(load) > longer]
    variance = np.mean([load.var(axis=0) for load in loads], axis=0)
    return np.median(np.mean(changes, axis=0) / (2 * variance)) if changes else None


def change_time(loads):
    """Returns the number of samples in which the load changes by a tenth of its variance."""
    before = None
    intervals = sorted({round(4000 ** (k / 59)) for k in range(60)})
    for interval in intervals:
        change = mean_change(loads, interval, 2 * interval)
        if change is None:
            return float(interval)
        if change >= 0.1:
            if before is None:
                return 1.0 if change > 0.4 else max(1.0, math.sqrt(0.1 / change))
            return before[0] + (interval - before[0]) * (0.1 - before[1]) / (change - before[1])
        before = (interval, change)
    return 4000.0


# The columns of the causes.


def shifted(values, by):
    return values[np.clip(np.arange(len(values)) + by, 0, len(values) - 1)]


def low_pass(values, samples):
    state, out = values[0], np.empty_like(values)
    kept = np.exp(-1 / samples)
    for k, value in enumerate(values):
        state = kept * state + (1 - kept) * value
        out[k] = state
    return out


def lag_columns(loads, change):
    near, far = max(1, round(0.1 * change)), max(2, round(0.4 * change))
    lags = sorted({near, far})
    if change < 4:
        return [shifted(loads, by) - loads for lag in lags for by in (-lag, lag)]
    slopes = [shifted(loads, lag) - shifted(loads, -lag) for lag in lags]
    return slopes + [shifted(loads, 2 * far) + shifted(loads, -2 * far) - shifted(loads, far) - shifted(loads, -far)]


def curvature_columns(inputs):
    pairs = itertools.combinations_with_replacement(range(inputs.shape[1]), 2)
    return np.stack([inputs[:, i] * inputs[:, j] for i, j in pairs] + [column**3 for column in inputs.T], axis=1)


def all_columns(recordings):
    """Returns the standardised gauges, and the columns of each cause, of each recording."""
    gauges = np.concatenate([own[0] for own in recordings])
    loads = np.concatenate([own[1] for own in recordings])
    warmth = np.concatenate([own[2] for own in recordings])
    ends = np.cumsum([len(own[0]) for own in recordings])[:-1]
    change = change_time([own[1] for own in recordings])
    is_table = mean_change([own[1] for own in recordings], 1, 1) > 0.5
    z = (gauges - gauges.mean(axis=0)) / gauges.std(axis=0)
    fit, *_ = np.linalg.lstsq(np.c_[np.ones(len(z)), z], loads - loads.mean(axis=0), rcond=None)
    conventional = z @ fit[1:]
    conventional = conventional / conventional.std(axis=0)
    predicted = conventional @ np.linalg.lstsq(conventional, z, rcond=None)[0]
    if z.shape[1] > 8:
        values, vectors = np.linalg.eigh(np.cov(z.T, bias=True))
        curved, played = z @ (vectors[:, ::-1][:, :8] / np.sqrt(values[::-1][:8])), conventional
    else:
        curved, played = z, predicted / (predicted.std(axis=0) + 1e-12)
    half = np.median([len(own[0]) for own in recordings]) / 2
    samples = [factor * change / 0.45 for factor in (1.5, 6, 24, 96) if factor * change / 0.45 <= half]
    columns = {"curvature": curvature_columns(curved)}
    if not is_table:
        parts, inputs = np.split(conventional, ends), np.split(played, ends)
        plays = [np.concatenate([own - backlash(own, radius) for radius in (0.1, 0.3, 0.8, 2.0)], axis=1) for own in inputs]
        columns["hysteresis"] = np.concatenate(plays)
        if samples:
            creeps = [np.concatenate([low_pass(own, tau) - own for tau in samples], axis=1) for own in parts]
            columns["creep"] = np.concatenate(creeps)
        columns["lag"] = np.concatenate([np.concatenate(lag_columns(own, change), axis=1) for own in parts])
    if warmth.shape[1]:
        columns["temperature"] = warmth
    for cause, own in columns.items():
        columns[cause] = (own - own.mean(axis=0)) / own.std(axis=0)
    if warmth.shape[1]:
        alone = columns["temperature"]
        columns["temperature"] = np.concatenate([alone] + [alone[:, [k]] * z for k in range(alone.shape[1])], axis=1)
    return z, columns, loads, change, is_table


# Units, blocks and noise.


def units_and_blocks(lengths, change):
    """Returns the samples of each unit, and the samples of each block of each unit."""
    starts = np.concatenate([[0], np.cumsum(lengths)])
    count = {1: 4, 2: 3}.get(len(lengths), 1)
    units = [part for start, n in zip(starts, lengths) for part in np.array_split(np.arange(start, start + n), count)]
    least = max(10, int(2 * change))
    blocks = [np.array_split(unit, min(8, max(1, len(unit) // least))) for unit in units]
    return units, blocks


def chunked(values, order):
    """Returns the differences of some order in chunks of 25, scaled to the variance of white noise."""
    changes = np.diff(values, order, axis=0) / math.sqrt(math.comb(2 * order, order))
    n = len(changes) // 25
    return changes[: 25 * n].reshape(n, 25, -1)


def noise_of(residuals, units):
    """Returns the noise of each axis, the order of the differences, and the limit of quiet chunks; None if it is unknown."""
    best = None
    for order in range(1, 5):
        chunks = np.concatenate([np.mean(chunked(residuals[unit], order) ** 2, axis=1) for unit in units])
        if len(chunks) < 4:
            return None
        medians = np.median(chunks, axis=0)
        if best is None or np.mean(medians / best[0]) < 1:
            best = medians, order, np.median(np.mean(chunks / medians, axis=1))
    return best


class NoiseRows:
    """Differences of rows in the quiet chunks, from which the noise of any coefficients follows."""

    def __init__(self, residuals, units, design, targets):
        self.medians, order, limit = noise_of(residuals, units)
        kept = []
        for unit in units:
            size = np.mean(np.mean(chunked(residuals[unit], order) ** 2, axis=1) / self.medians, axis=1)
            rows = np.concatenate([design[unit], targets[unit], residuals[unit]], axis=1)
            kept.append(chunked(rows, order)[size <= limit].reshape(-1, rows.shape[1]))
        kept = np.concatenate(kept)
        self.design, self.targets, own = np.split(kept, np.cumsum([design.shape[1], targets.shape[1]]), axis=1)
        self.scale = self.medians / np.mean(own**2, axis=0)

    def passed_on(self, columns, weights, axis):
        changes = self.targets[:, axis] - self.design[:, columns] @ weights
        return self.scale[axis] * np.mean(changes**2)


# Held-out errors.


def fitted(rows, targets, ridge):
    return np.linalg.solve(rows.T @ rows + np.diag(ridge), rows.T @ targets)


def taken_out(values, freedoms):
    """Returns the values of one unit after its own multiples of the freedoms are taken out."""
    return values - freedoms @ np.linalg.lstsq(freedoms, values, rcond=None)[0] if freedoms.shape[1] else values


def far_pairs(values, near):
    far = np.abs(np.subtract.outer(np.arange(len(values)), np.arange(len(values)))) >= near
    return values @ far @ values


def unit_gains(blocks, error, corrected, time, names):
    """Returns for each freedom of a unit its gain, the variance of the gain by chance, its score and its weight."""
    if len(blocks) < 2:
        return {name: (0.0, 0.0, 0.0, 0.0) for name in names}
    shapes = {"zeros": np.ones_like(error), "drift": time, "sensitivity": corrected}
    left, directions, out = error.copy(), [], {}
    for name in names:
        direction = shapes[name].copy()
        for own in directions:
            direction = direction - own * (own @ direction) / (own @ own)
        directions.append(direction)
        weights = np.array([direction[block] @ direction[block] for block in blocks])
        scores = np.array([direction[block] @ left[block] for block in blocks])
        weight, scale, used = weights.sum(), 0.0, 1
        for near in (min(2, len(blocks) - 1), 1):
            if far_pairs(weights, near) > 0.2 * weight**2:
                scale, used = weight / far_pairs(weights, near), near
                break
        out[name] = [scale * far_pairs(scores, used), scale, used, scores.sum(), weight]
        left = left - direction * scores.sum() / weight
    freedom = len(blocks) / max(1, len(blocks) - len(names))
    for name, direction in zip(names, directions):
        gain, scale, used, score, weight = out[name]
        squares = freedom * np.array([(direction[block] @ left[block]) ** 2 for block in blocks])
        out[name] = gain, 2 * scale**2 * far_pairs(squares, used), score, weight
    return out


def held_out(model, axis, causes, freedoms, ridge):
    """Returns the squared error of each block, the gains of each freedom summed over units, and the noise that is passed on."""
    units, blocks, design, loads, mean = model["units"], model["blocks"], model["design"], model["loads"], model["mean"]
    chosen = np.concatenate([model["base"]] + [model["of_cause"][cause] for cause in causes])
    squares, reductions, gains, noise = [None] * len(units), [], {name: [] for name in freedoms}, 0.0
    n_total = len(design)
    for fold in np.array_split(np.arange(len(units)), min(len(units), 10)):
        training = [unit for at, unit in enumerate(units) if at not in fold]
        own = [name for name in freedoms if name != "sensitivity"]
        columns = chosen[1:] if "zeros" in own else chosen
        rows, targets = [], []
        for unit in training:
            shapes = {"zeros": np.ones(len(unit)), "drift": np.linspace(-1, 1, len(unit))}
            basis = np.stack([shapes[name] for name in own], axis=1) if own else np.empty((len(unit), 0))
            part = taken_out(np.c_[design[unit], loads[unit, axis] - mean[axis]], basis)
            rows.append(part[:, columns])
            targets.append(part[:, -1])
        rows, targets = np.concatenate(rows), np.concatenate(targets)
        strengths = np.where(columns < len(model["base"]), 1e-9, ridge) * len(rows)
        weights = fitted(rows, targets, strengths)
        if "zeros" in own:
            raw = np.concatenate(training)
            offset = np.mean(loads[raw, axis] - mean[axis] - design[raw][:, columns] @ weights)
            weights, columns = np.r_[offset, weights], chosen
        for at in fold:
            unit = units[at]
            predicted = design[unit][:, columns] @ weights
            error = loads[unit, axis] - mean[axis] - predicted
            inside = [block - unit[0] for block in blocks[at]]
            squares[at] = np.array([np.sum(error[block] ** 2) for block in inside])
            found = unit_gains(inside, error, predicted + mean[axis], np.linspace(-1, 1, len(unit)), freedoms)
            for name in freedoms:
                gains[name].append(found[name])
        if model["noise"]:
            noise += model["noise"].passed_on(columns, weights, axis) * sum(len(units[at]) for at in fold) / n_total
    of_units = np.zeros(len(units))
    summed = {}
    for name in freedoms:
        gain, variance, score, weight = np.array(gains[name]).T
        if name == "sensitivity":
            common = score.sum() / weight.sum()
            gain = gain - 2 * common * score + common**2 * weight
        of_units += gain
        summed[name] = gain.sum(), variance.sum()
    kept = [own * (1 - gain / own.sum()) for own, gain in zip(squares, of_units)]
    return np.concatenate(kept), np.concatenate(squares), summed, noise


# The decision.


def subsets(of):
    return [frozenset(own) for n in range(len(of) + 1) for own in itertools.combinations(of, n)]


def budget(recordings):
    z, columns, loads, change, is_table = all_columns(recordings)
    units, blocks = units_and_blocks([len(own[0]) for own in recordings], change)
    full_scale = np.ptp(loads, axis=0) / 2
    mean = loads.mean(axis=0)
    base = np.arange(1 + z.shape[1])
    of_cause, at = {}, len(base)
    for cause, own in columns.items():
        of_cause[cause] = np.arange(at, at + own.shape[1])
        at += own.shape[1]
    design = np.concatenate([np.ones((len(z), 1)), z] + list(columns.values()), axis=1)
    centred = loads - mean
    residuals = centred - design[:, base] @ fitted(design[:, base], centred, np.full(len(base), 1e-9 * len(z)))
    known = change >= 4 and noise_of(residuals, units) is not None
    noise = NoiseRows(residuals, units, design, centred) if known else None
    model = dict(units=units, blocks=blocks, design=design, loads=loads, mean=mean, base=base, of_cause=of_cause, noise=noise)
    floor = np.zeros(len(mean))
    if noise:
        gauges = np.arange(1, len(base))
        spread = noise.design[:, gauges].T @ noise.design[:, gauges] / len(noise.design)
        forward = np.linalg.lstsq(centred, z, rcond=None)[0]
        inverse = np.linalg.inv(spread + 1e-9 * np.trace(spread) / len(spread) * np.eye(len(spread)))
        best = inverse @ forward.T @ np.linalg.pinv(forward @ inverse @ forward.T)
        floor = [min(noise.medians[axis], noise.passed_on(gauges, best[:, axis], axis)) for axis in range(len(mean))]
    segments = len(recordings) < 3
    of_units = ["zeros"] + ([] if segments else ([] if is_table else ["drift"]) + ["sensitivity"])
    lengths = np.array([len(block) for own in blocks for block in own], float)
    figures = {}
    for causes, freedoms in itertools.product(subsets(list(columns)), subsets(of_units)):
        names = [name for name in UNIT_CAUSES if name in freedoms]
        ordered = [cause for cause in columns if cause in causes]
        for axis, scale in enumerate(full_scale**2):
            choices = [held_out(model, axis, ordered, names, ridge) for ridge in (RIDGES if causes else RIDGES[:1])]
            kept, raw, gains, passed = min(choices, key=lambda own: own[0].sum())
            gains = {name: (gain / scale, variance / scale**2) for name, (gain, variance) in gains.items()}
            figures[causes | freedoms, axis] = kept / scale, min(passed, floor[axis]) / scale, gains
    tested = list(columns) + of_units
    everything = dict(figures=figures, lengths=lengths, tested=tested)
    axes = [decision(axes=[axis], **everything) for axis in range(len(mean))]
    pooled = decision(axes=list(range(len(mean))), **everything)
    return dict(full_scale=full_scale.tolist(), h10=change, axes=axes, all=pooled)


def decision(figures, lengths, tested, axes):
    raw = {own: sum(figures[own, axis][0] for axis in axes) for own in subsets(tested)}
    clear = {own: raw[own] - lengths * sum(figures[own, axis][1] for axis in axes) for own in raw}
    n, none = lengths.sum() * len(axes), frozenset()
    total = raw[none].sum() / n
    mean = {own: clear[own].sum() / n for own in clear}
    critical = student.ppf(0.99, max(2, len(lengths) - 1))

    def need(chosen, cause):
        less = chosen - {cause}
        if cause in UNIT_CAUSES:
            gain, variance = np.sum([figures[chosen, axis][2][cause] for axis in axes], axis=0)
            certain = gain / math.sqrt(variance + 1e-300) / 4
        else:
            relative = np.clip((clear[less] - clear[chosen]) / (raw[less] + raw[chosen]), -1, 1)
            certain = relative.mean() / (relative.std(ddof=1) / math.sqrt(len(relative)) + 1e-9) / critical
        return min(certain, (mean[less] - mean[chosen]) / (0.02 * total))

    chosen = min(mean, key=lambda own: mean[own] + 0.001 * total * len(own))
    while chosen:
        weakest = min(chosen, key=lambda cause: need(chosen, cause))
        if need(chosen, weakest) >= 1:
            break
        chosen -= {weakest}
    for _ in range(3):
        outside = {cause: need(chosen | {cause}, cause) for cause in tested if cause not in chosen}
        strongest = max(outside, key=outside.get, default=None)
        if strongest is None or outside[strongest] < 1:
            break
        chosen |= {strongest}
    rest = max(mean[chosen], 0.0)
    out = dict(total=total, shares={}, se={}, alternatives={}, noise=min(total - mean[none], total), unexplained=rest)
    for cause in chosen:
        orders = list(itertools.permutations(chosen))
        value = 0.0
        for order in orders:
            before = frozenset(order[: order.index(cause)])
            value = value + (clear[before] - clear[before | {cause}]) / len(orders)
        share = value.sum() / n
        if share < max(0.02 * total, 0.3 * rest):
            out["unexplained"] += max(share, 0.0)
            continue
        less = chosen - {cause}
        gain = mean[less] - mean[chosen]
        swaps = [other for other in tested if other not in chosen]
        part = {other: 0.5 if {cause, other} == {"zeros", "temperature"} else 0.8 for other in swaps}
        out["alternatives"][cause] = [own for own in swaps if mean[less] - mean[less | {own}] > part[own] * gain]
        out["shares"][cause] = share
        out["se"][cause] = math.sqrt(np.sum((value - share * lengths * len(axes)) ** 2)) / n
    return out


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    expected = {}
    for name, recordings in SENSORS.items():
        expected[name] = budget(written(name, recordings))
        shown = {cause: round(100 * math.sqrt(share), 2) for cause, share in expected[name]["all"]["shares"].items()}
        total, noise, rest = (100 * math.sqrt(max(expected[name]["all"][own], 0)) for own in ("total", "noise", "unexplained"))
        print(f"{name}: {total:.2f} = {shown}, noise {noise:.2f}, unexplained {rest:.2f}")
    (FOLDER / "golden.json").write_text(json.dumps(expected, indent=1) + "\n")
