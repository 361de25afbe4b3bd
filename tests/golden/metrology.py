"""Makes metrology_expected.json: the loop and error figures of the recordings in this folder by an independent, plain
implementation of their definitions. Needs NumPy, and the recordings that generate.py makes. Run it here: python3 metrology.py
"""

import json

import numpy as np

from generate import HERE, calibrate, read

CELLS = 100
STEPS = 101
FULL = 0.8


def dead_band(recordings):
    """Ten times the noise by fourth differences, at least 2 % of the range."""
    noise = [np.sort(np.abs(np.diff(x, 4)))[(len(x) - 5) // 2] / np.sqrt(70.0) / 0.6744897501960817 for x in recordings]
    every = np.concatenate(recordings)
    return max(10.0 * max(noise), 0.02 * np.ptp(every))


def reversals(x, band):
    """Ends of the branches, sample by sample: the farthest point so far, once the load is back by more than the band."""
    ends, start, direction = [0], 0, 0
    for k in range(len(x)):
        seen = x[start : k + 1]
        low, high = start + np.argmin(seen), start + np.argmax(seen)
        if direction == 0 and x[high] - x[low] > band:
            direction = 1 if high > low else -1
        elif direction == 1 and x[high] - x[k] > band:
            ends.append(high)
            start, direction = high, -1
        elif direction == -1 and x[k] - x[low] > band:
            ends.append(low)
            start, direction = low, 1
    return [(a, b) for a, b in zip(ends, ends[1:] + [len(x) - 1])] if direction else []


class Branch:
    """Averages over hundredths of the load range, between the samples of least and greatest load."""

    def __init__(self, recording, x, outputs, ends):
        own = slice(ends[0], ends[1] + 1)
        self.recording, self.x, self.outputs = recording, x[own], [y[own] for y in outputs]
        self.low, self.high = self.x.min(), self.x.max()
        self.rising = x[ends[1]] > x[ends[0]]

    def averages(self, output):
        y = self.outputs[output]
        cell = np.minimum(((self.x - self.low) * (CELLS / (self.high - self.low))).astype(int), CELLS - 1)
        used = np.unique(cell)
        return np.array([[self.x[cell == c].mean(), y[cell == c].mean()] for c in used])

    def at(self, loads, output):
        y, averages = self.outputs[output], self.averages(output)
        gap = 1e-9 * (self.high - self.low)
        inner = averages[(averages[:, 0] > self.low + gap) & (averages[:, 0] < self.high - gap)]
        first, last = np.argmin(self.x), np.argmax(self.x)
        knots = np.vstack([[self.low, y[first]], inner, [self.high, y[last]]])
        return np.interp(loads, knots[:, 0], knots[:, 1])

    def ends(self, output):
        """The outer two averages carried on to the ends."""
        a = self.averages(output)
        carry = lambda load, p, q: p[1] + (q[1] - p[1]) * (load - p[0]) / (q[0] - p[0])
        return np.array([[self.low, carry(self.low, a[0], a[1])], [self.high, carry(self.high, a[-1], a[-2])]])


def common(parts):
    return max(part.low for part in parts), min(part.high for part in parts)


def span(parts):
    low, high = common(parts)
    return high - low


def most_of(own, whole):
    return min(own[1], whole[1]) - max(own[0], whole[0]) >= FULL * (whole[1] - whole[0])


def widths(cycle, loads, output):
    rising, falling = sorted(cycle, key=lambda branch: not branch.rising)
    return falling.at(loads, output) - rising.at(loads, output)


def figures(recordings, outputs):
    """Every figure of one axis, conventional and compensated: recordings of one load, outputs[o] of the same shapes."""
    band = dead_band(recordings)
    branches = [
        [Branch(r, x, [outputs[o][r] for o in range(2)], ends) for ends in reversals(x, band)]
        for r, x in enumerate(recordings)
    ]
    cycles = [pair for own in branches for pair in zip(own, own[1:])]
    every = [branch for own in branches for branch in own]
    found = {}
    largest = cycles[int(np.argmax([span(cycle) for cycle in cycles]))]
    full = [cycle for cycle in cycles if most_of(common(cycle), common(largest))]
    rising = next(branch for branch in largest if branch.rising)
    falling = next(branch for branch in largest if not branch.rising)

    def both(name, figure):
        found[name] = [float(figure(output)) for output in range(2)]

    both("hysteresis", lambda o: np.abs(widths(largest, np.linspace(*common(largest), STEPS), o)).max())
    low, high = max(common(c)[0] for c in full), min(common(c)[1] for c in full)

    def mean_widths(output):
        """Each loop on its own 101 loads first, then on those of the mean."""
        loads, total = np.linspace(low, high, STEPS), 0.0
        for cycle in full:
            own = np.linspace(*common(cycle), STEPS)
            total = total + np.interp(loads, own, widths(cycle, own, output))
        return np.abs(total / len(full))

    both("hysteresis_mean_loop", lambda o: mean_widths(o).max())
    both("hysteresis_mean_width", lambda o: np.trapezoid(mean_widths(o), dx=1.0 / (STEPS - 1)))

    def terminal(points, output):
        (x0, y0), (x1, y1) = rising.ends(output)
        return np.abs(points[:, 1] - y0 - (y1 - y0) / (x1 - x0) * (points[:, 0] - x0)).max()

    def best_fit(output):
        points = rising.averages(output)
        slope, offset = np.polyfit(points[:, 0], points[:, 1], 1)
        points = np.vstack([points, rising.ends(output)])
        return np.abs(points[:, 1] - slope * points[:, 0] - offset).max()

    def combined(output):
        points = falling.averages(output)
        inside = (points[:, 0] >= common(largest)[0]) & (points[:, 0] <= common(largest)[1])
        return terminal(np.vstack([rising.averages(output), points[inside]]), output)

    both("nonlinearity_terminal", lambda o: terminal(rising.averages(o), o))
    both("nonlinearity_best_fit", best_fit)
    both("combined_error", combined)

    def spread(output):
        worst = None
        for way in (True, False):
            same = [branch for branch in every if branch.rising == way]
            widest = same[int(np.argmax([branch.high - branch.low for branch in same]))]
            for r in range(len(recordings)):
                own = [b for b in same if b.recording == r and most_of((b.low, b.high), (widest.low, widest.high))]
                if len(own) > 1:
                    loads = np.linspace(*common(own), STEPS)
                    found_here = np.ptp([branch.at(loads, output) for branch in own], axis=0).max()
                    worst = found_here if worst is None else max(worst, found_here)
        return worst

    spreads = [spread(output) for output in range(2)]
    found["repeatability"] = [None if one is None else float(one) for one in spreads]
    errors = [np.abs(np.concatenate(outputs[o]) - np.concatenate(recordings)) for o in range(2)]
    both("rmse", lambda o: np.sqrt(np.mean(errors[o] ** 2)))
    both("largest_error", lambda o: errors[o].max())
    both("error_95", lambda o: np.sort(errors[o])[int(np.ceil(0.95 * len(errors[o]))) - 1])
    return band, found


def case(files, distance, f_th):
    _, outputs = calibrate(train=files, test=files, f_th=f_th, t_th=15.0, distance=distance)
    parts = [read(name) for name in files]
    cuts = np.cumsum([len(part[0]) for part in parts])[:-1]
    axes = []
    for i, axis in enumerate(parts[0][3]):
        recordings = [part[2][:, i] for part in parts]
        band, found = figures(recordings, [np.split(output[:, i], cuts) for output in outputs])
        axes.append({"axis": axis, "dead_band": float(band), "figures": found})
    return {"files": files, "axes": axes}


def main():
    cases = [
        case(["two_gauges.csv"], "force", 3.0),
        case([f"eight_gauges_train_{k}.csv" for k in (1, 2, 3)], "force", 3.0),
        case([f"moment_only_train_{k}.csv" for k in (1, 2, 3, 4)], "full-scale", 0.25),
    ]
    (HERE / "metrology_expected.json").write_text(json.dumps({"cases": cases}, indent=1) + "\n")


if __name__ == "__main__":
    main()
