"""Makes metrology_expected.json: loop and error figures of the recordings in this folder, by a plain implementation of their definitions
that shares no code with the program. Needs NumPy, and the recordings that generate.py makes. Run in this folder: python3 metrology.py
"""

import json

import numpy as np

from generate import HERE, calibrate, read

CELLS = 100
STEPS = 101
FULL = 0.8
FEWEST, MOST = 3, 0.5
ALIKE = 0.05
QUIET, QUIET_PATH, WIDEST, SURE = 0.02, 0.05, 12, 3.0


def reversal_threshold(recordings):
    """Returns ten times the noise of the load, estimated by fourth differences, but at least 5 % of the load's range."""
    noise = [np.sort(np.abs(np.diff(x, 4)))[(len(x) - 5) // 2] / np.sqrt(70.0) / 0.6744897501960817 for x in recordings]
    every = np.concatenate(recordings)
    return max(10.0 * max(noise), 0.05 * np.ptp(every))


def reversals(x, band):
    """Returns the first and last sample of each branch. A branch ends at its extreme load, if the load then turns back by more than `band`."""
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
    """A branch of a loop, with the samples `own`. The curve of a branch goes through averages over hundredths of the load range, and through
    the samples of smallest and largest load."""

    def __init__(self, recording, x, outputs, own, rising):
        self.recording, self.own, self.rising = recording, own, rising
        self.x, self.outputs = x[own], [y[own] for y in outputs]
        self.low, self.high = self.x.min(), self.x.max()

    @property
    def span(self):
        return self.high - self.low

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


def cycles_of(recording, x, outputs, band):
    """Returns three lists by rainflow: closed cycles with paired half cycles, closed cycles with all neighbouring half cycles, and the half
    cycles that do not close."""
    whole = lambda a, b: Branch(recording, x, outputs, np.arange(a, b + 1), x[b] > x[a])
    left = [whole(a, b) for a, b in reversals(x, band)]
    closed, at = [], 0
    while at + 2 < len(left):
        before, own, after = left[at : at + 3]
        alike = before.span == own.span == after.span
        if own.span > min(before.span, after.span) or alike:
            at += 1
            continue
        back = x[after.own] >= own.high if after.rising else x[after.own] <= own.low
        end = int(np.argmax(back))
        second = Branch(recording, x, outputs, after.own[: end + 1], after.rising)
        closed.append((own, second))
        joined = np.r_[before.own, after.own[end:]]
        left[at : at + 3] = [Branch(recording, x, outputs, joined, before.rising)]
        at = 0
    # Of all ways to pair neighbouring half cycles, the pairing with the largest sum of squared common ranges is chosen.
    best = {len(left): (0.0, []), len(left) + 1: (0.0, [])}
    for k in reversed(range(len(left))):
        alone = best[k + 1]
        best[k] = alone
        if k + 1 < len(left):
            pair = (left[k], left[k + 1])
            joint = (span(pair) ** 2 + best[k + 2][0], [pair] + best[k + 2][1])
            if joint[0] >= alone[0]:
                best[k] = joint
    return closed + best[0][1], closed + list(zip(left, left[1:])), left


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


def quiet(values, share=QUIET, sure=SURE):
    """Returns the values, smoothed by straight lines through neighbours, and the noise that is left at the ends. The number of neighbours is
    the smallest that reduces twice the noise to this share of the largest value. At each value, the longest line is used whose interval of
    `sure` standard deviations intersects those of all shorter lines."""
    bends = np.sort(np.abs(np.diff(values, 2)))
    noise = bends[len(bends) // 2] / 0.6745 / np.sqrt(6.0)
    smooth, low, high = np.array(values), np.full(len(values), -np.inf), np.full(len(values), np.inf)
    for half in range(WIDEST + 1):
        for k in range(len(values)):
            near = np.arange(max(k - half, 0), min(k + half + 1, len(values)))
            x = near - near.mean()
            weights = 1.0 / len(near) + x * (k - near.mean()) / (x @ x or 1.0)
            value, margin = weights @ values[near], sure * noise * np.sqrt(weights @ weights)
            low[k], high[k] = max(low[k], value - margin), min(high[k], value + margin)
            if low[k] <= high[k]:
                smooth[k] = value
        if 2.0 * noise / np.sqrt(2 * half + 1) <= share * np.abs(smooth).max():
            break
    return smooth, noise * np.sqrt(4.0 / (half + 4.0))


def above_noise(size, noise):
    """Returns the size without the noise; None for less than three standard deviations of the noise."""
    return None if size <= 3.0 * noise else float(np.sqrt(size**2 - noise**2))


def shared(branches, output):
    """Returns the loads of the first branch's averages that lie between the outer averages of all branches."""
    averages = [branch.averages(output)[:, 0] for branch in branches]
    loads = averages[0]
    return loads[(loads >= max(own[0] for own in averages)) & (loads <= min(own[-1] for own in averages))]


def path(branches, output):
    """Returns the points of the mean of branches with one direction, smoothed around their best-fit line, and their noise."""
    loads, (low, high) = shared(branches, output), common(branches)
    mean = np.mean([branch.at(loads, output) for branch in branches], axis=0)
    line = np.polyval(np.polyfit(loads, mean, 1), loads)
    off, noise = quiet(mean - line, QUIET_PATH, np.inf)
    points = np.column_stack([loads, line + off])
    carry = lambda load, p, q: [load, p[1] + (q[1] - p[1]) * (load - p[0]) / (q[0] - p[0])]
    ends = carry(low, points[0], points[1]), carry(high, points[-1], points[-2])
    return np.vstack([ends[0], points, ends[1]]), noise


def figures(recordings, outputs, others, full_scales):
    """Returns every figure of one axis, conventional and compensated. `recordings` are the loads of this axis, and outputs[o] have the same
    shapes. `others` are the loads of the other axes, per recording one column for each axis, with their full scales."""
    band = reversal_threshold(recordings)
    every = np.concatenate(recordings)
    counted = [
        cycles_of(r, x, [outputs[o][r] for o in range(2)], band) for r, x in enumerate(recordings)
    ]
    cycles = [cycle for own in counted for cycle in own[0]]
    neighbours = [cycle for own in counted for cycle in own[1]]
    found = {}
    starts = lambda cycle: (cycle[0].recording, cycle[0].own[0])
    largest = max(sorted(neighbours, key=starts), key=span)
    full = [cycle for cycle in cycles if most_of(common(cycle), common(largest))]

    def both(name, figure):
        values = [figure(output) for output in range(2)]
        found[name] = [None if value is None else float(value) for value in values]

    both("hysteresis", lambda o: np.abs(quiet(widths(largest, np.linspace(*common(largest), STEPS), o))[0]).max())
    low, high = max((common(c)[0] for c in full), default=0), min((common(c)[1] for c in full), default=0)

    averaged = sorted(full, key=starts)
    if len(full) < FEWEST or high - low <= MOST * np.ptp(every):
        averaged, (low, high) = [largest], common(largest)

    def mean_widths(output):
        """Returns the widths of the mean loop. Each loop is interpolated on its own 101 loads, and then on the 101 loads of the mean loop."""
        loads, total = np.linspace(low, high, STEPS), 0.0
        for cycle in averaged:
            own = np.linspace(*common(cycle), STEPS)
            total = total + np.interp(loads, own, widths(cycle, own, output))
        return np.abs(quiet(total / len(averaged))[0])

    found["hysteresis_mean_loop"] = [None, None]
    if len(averaged) > 1:
        both("hysteresis_mean_loop", lambda o: mean_widths(o).max())
    both("loop_area", lambda o: np.trapezoid(mean_widths(o), dx=(high - low) / (STEPS - 1)))

    def way(rising, output):
        return path([branch for cycle in averaged for branch in cycle if branch.rising == rising], output)

    def off_line(points, ends):
        (x0, y0), (x1, y1) = ends[0], ends[-1]
        return np.abs(points[:, 1] - y0 - (y1 - y0) / (x1 - x0) * (points[:, 0] - x0)).max()

    def terminal(output):
        points, noise = way(True, output)
        return above_noise(off_line(points, points), noise)

    def best_fit(output):
        points, noise = way(True, output)
        slope, offset = np.polyfit(points[1:-1, 0], points[1:-1, 1], 1)
        return above_noise(np.abs(points[:, 1] - slope * points[:, 0] - offset).max(), noise)

    def combined(output):
        (rising, one), (falling, other) = way(True, output), way(False, output)
        inside = (falling[:, 0] >= low) & (falling[:, 0] <= high)
        return above_noise(off_line(np.vstack([rising, falling[inside]]), rising), np.hypot(one, other))

    both("nonlinearity_terminal", terminal)
    both("nonlinearity_best_fit", best_fit)
    both("combined_error", combined)

    def apart(branches, values):
        """Returns the differences of branches with the same direction from their mean, at equal loads."""
        curves = [Branch(b.recording, recordings[b.recording], [values[b.recording]], b.own, b.rising) for b in branches]
        loads = shared(curves, 0)
        found = np.array([curve.at(loads, 0) for curve in curves])
        return found - found.mean(axis=0)

    def spread(output):
        worst = None
        for r, x in enumerate(recordings):
            large = [Branch(r, x, [], np.arange(a, b + 1), x[b] > x[a]) for a, b in reversals(x, 0.5 * span(largest))]
            for branch, end in ((large[0], False), (large[-1], True)) if large else ():
                # Before the start of the first cycle and after the end of the last cycle, the load may have moved the other way by up to the
                # reversal threshold. These samples are removed.
                highest = branch.rising == end
                k = int(np.argmax(branch.x[::-1] if highest else -branch.x[::-1]))
                k = len(branch.x) - 1 - k
                branch.own = branch.own[: k + 1] if end else branch.own[k:]
            near = lambda a, b: max(abs(a.low - b.low), abs(a.high - b.high)) <= ALIKE * span(largest) and (
                b.span >= FULL * span(largest)
            )
            start = 0
            while start < len(large):
                same = [large[start]]
                while start + len(same) < len(large) and near(same[0], large[start + len(same)]):
                    same.append(large[start + len(same)])
                start += len(same) if len(same) >= 4 else 1
                if len(same) < 4:
                    continue
                ways = [[b for b in same if b.rising == way] for way in (True, False)]
                differ = [
                    np.ptp(apart(way, [own[:, k] for own in others]), axis=0).max() > ALIKE * full_scale
                    for k, full_scale in enumerate(full_scales)
                    for way in ways
                ]
                if not any(differ):
                    smooth = [[quiet(own, QUIET_PATH, np.inf) for own in apart(way, outputs[output])] for way in ways]
                    sizes = [(np.ptp([own for own, _ in way], axis=0).max(), max(left for _, left in way)) for way in smooth]
                    size, left = max(sizes)
                    here = above_noise(size, 2.0 * left)
                    worst = max(worst or 0.0, here) if here else worst
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
        all_but = [np.delete(part[2], i, axis=1) for part in parts]
        full_scales = np.ptp(np.vstack(all_but), axis=0) / 2.0 if all_but[0].shape[1] else []
        band, found = figures(recordings, [np.split(output[:, i], cuts) for output in outputs], all_but, full_scales)
        axes.append({"axis": axis, "reversal_threshold": float(band), "figures": found})
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
