"""Makes blocks_expected.json: errors of fits with every feature block and with a ridge, by a plain implementation that shares no code
with the program. Needs NumPy, and the recordings that generate.py makes. Run in this folder: python3 blocks.py
"""

import json

import numpy as np

from generate import FORCES, HERE, arguments, full_scale_of, left_out_folds, least_squares, past_samples, play, read, rmse, with_offset


def lagged(times, gauges, lag):
    """Returns the gauges at the time t - lag, interpolated. Before the lag has passed, returns the present gauges."""
    wanted = times - lag
    columns = [np.interp(wanted, times, column) for column in gauges.T]
    return np.where((wanted >= times[0])[:, None], np.stack(columns, axis=1), gauges)


def low_passed(times, gauges, tau):
    """Returns a first-order low-pass of the gauges, which are constant between samples. The difference between low-pass and gauges is
    weighted by the share of the initial state that has decayed."""
    out = gauges.copy()
    for k in range(1, len(times)):
        share = 1.0 - np.exp(-(times[k] - times[k - 1]) / tau)
        out[k] = out[k - 1] + share * (gauges[k] - out[k - 1])
    weights = 1.0 - np.exp(-(times - times[0]) / tau)
    return gauges + weights[:, None] * (out - gauges)


def known_play(signal, radius):
    """Returns the play operator. Until the signal has travelled twice the radius, the operator depends on its start. Its difference to the
    signal is weighted by a share that rises from 0 to 1 as the travel rises from the radius to twice the radius, by at most 0.03 from one
    sample to the next."""
    travel = np.maximum.accumulate(signal) - np.minimum.accumulate(signal)
    most = 0.03 * np.arange(len(signal))
    share = np.minimum.accumulate(np.clip(travel / max(radius, 1e-300) - 1.0, 0.0, 1.0) - most) + most
    return signal + share * (play(signal, radius) - signal)


def monomials(z, degree):
    n = z.shape[1]
    columns = [z[:, i] * z[:, j] for i in range(n) for j in range(i, n)] if degree > 1 else []
    columns += [z[:, i] ** 3 for i in range(n)] if degree > 2 else []
    return np.stack(columns, axis=1) if columns else np.empty((len(z), 0))


def solve(design, target, shrunk, strength):
    """Returns the ridge solution: least squares on the samples and additional rows for the penalties."""
    penalties = np.sqrt(strength * np.sum(design**2, axis=0)) * shrunk
    rows = np.diag(penalties)[shrunk & (penalties > 0)]
    padded = np.vstack([design, rows])
    return least_squares(padded, np.vstack([target, np.zeros((len(rows), target.shape[1]))]))


def calibrate(train, test, f_th, t_th, distance, look_back, lags, creep, radii, degree, ridge, offset=True):
    """Returns the errors that the program reports for a fit with these blocks."""
    train, test = [read(name) for name in train], [read(name) for name in test]
    axes = train[0][3]
    train, test = [part[:3] for part in train], [part[:3] for part in test]
    gauges, truth = (np.vstack([part[at] for part in train]) for at in (1, 2))
    full_scale = full_scale_of(truth)
    is_force = np.array([1.0 if axis in FORCES else 0.0 for axis in axes])
    weights = is_force if distance == "force" else 1.0 / full_scale
    deviation = np.where(np.ptp(gauges, axis=0) > 0.0, gauges.std(axis=0), 0.0)
    shift = gauges.mean(axis=0) if offset else np.zeros(gauges.shape[1])
    size = deviation if offset else np.sqrt(np.mean(gauges**2, axis=0))
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    conventional = least_squares(with_offset(gauges, offset), truth)

    def design(part):
        times, gauges, _ = part
        loads = with_offset(gauges, offset) @ conventional
        histories = [gauges[past_samples(times, loads, weights, f, t_th)] for f in look_back]
        histories += [lagged(times, gauges, lag) for lag in lags]
        histories += [low_passed(times, gauges, tau) for tau in creep]
        for radius in radii:
            columns = [known_play(column, radius * spread) for column, spread in zip(gauges.T, deviation)]
            histories.append(np.stack(columns, axis=1))
        z = (gauges - shift) * inverse
        columns = np.hstack([z] + [(history - gauges) * inverse for history in histories] + [monomials(z, degree)])
        return with_offset(columns, offset)

    designs, test_designs = [design(part) for part in train], [design(part) for part in test]
    columns = np.vstack(designs)
    shrunk = np.zeros(columns.shape[1], bool)
    shrunk[gauges.shape[1] : columns.shape[1] - int(offset)] = True
    residual = truth - with_offset(gauges, offset) @ conventional
    found = solve(columns, residual, shrunk, ridge)
    cv = np.empty_like(residual)
    for fold in left_out_folds([len(part[0]) for part in train]):
        rest = np.setdiff1d(np.arange(len(columns)), fold)
        cv[fold] = columns[fold] @ solve(columns[rest], residual[rest], shrunk, ridge) - residual[fold]
    tested = np.vstack([part[2] - with_offset(part[1], offset) @ conventional for part in test])
    return {
        "axes": axes,
        "compensated": {
            "train_rmse": rmse(columns @ found - residual).tolist(),
            "cv_rmse": rmse(cv).tolist(),
            "test_rmse": rmse(np.vstack(test_designs) @ found - tested).tolist(),
        },
    }


def words(look_back, lags, creep, radii, degree, ridge):
    """Returns the blocks as command-line arguments."""
    listed = lambda values: ",".join(repr(value) for value in values)
    out = ["--look-back", listed(look_back) if look_back else "none"]
    for flag, values in (("--fixed-lag", lags), ("--creep", creep), ("--play", radii)):
        out += [flag, listed(values)] if values else []
    return out + ["--polynomial", str(degree), "--ridge", repr(ridge)]


def main():
    none = dict(look_back=[], lags=[], creep=[], radii=[], degree=1, ridge=0.0)
    six = dict(
        train=[f"eight_gauges_train_{k}.csv" for k in (1, 2, 3)],
        test=["eight_gauges_test_1.csv"],
        f_th=0.0,
        t_th=1.5,
        distance="force",
    )
    moment = dict(
        train=[f"moment_only_train_{k}.csv" for k in (1, 2, 3, 4)],
        test=["moment_only_test_1.csv"],
        f_th=0.0,
        t_th=4.0,
        distance="full-scale",
    )
    fits = []
    for sensor, base, changes in (
        (
            "eight_gauges",
            six,
            (
                dict(look_back=[25.0, 60.0]),
                dict(lags=[0.043, 0.5]),
                dict(degree=2),
                dict(degree=3, ridge=0.03),
                dict(look_back=[25.0], lags=[0.2], creep=[0.3], radii=[0.2, 0.4, 1.1], degree=2, ridge=0.01),
            ),
        ),
        (
            "moment_only",
            moment,
            # Loads of these fits do not fade in, which this implementation cannot do.
            (
                dict(creep=[0.3]),
                dict(radii=[0.1, 0.5]),
                dict(radii=[0.1, 0.5], offset=False),
                dict(look_back=[0.25], radii=[0.3], creep=[1.0], ridge=0.2),
            ),
        ),
    ):
        for change in changes:
            offset = change.pop("offset", True)
            blocks = none | change
            report = calibrate(**base, **blocks, offset=offset)
            choices = arguments(**base, offset=offset)
            at = choices.index("--f-th")
            choices = choices[:at] + choices[at + 2 :] + words(**blocks)
            fits.append({"sensor": sensor, "arguments": choices, "expected": report})
    (HERE / "blocks_expected.json").write_text(json.dumps({"fits": fits}, indent=1) + "\n")


if __name__ == "__main__":
    main()
