"""Computes loads from a calibration file by the rules of assets/guide/calibration-file.md: python3 reference_reader.py c.json samples.txt"""
import json, sys
import numpy as np


def loads(cal, samples):
    shift, inverse, sd = (np.array(cal["gauge_scale"][key]) for key in ("shift", "inverse_scale", "deviation"))
    features, full_scale, g = cal["features"], np.array(cal["full_scale"]), len(cal["gauges"])
    forces = np.array([axis[0] == "F" for axis in cal["axes"]], dtype=float)
    by_force = features["distance"] == "force" and forces.any()
    weights = forces if by_force else np.where(full_scale > 0, 1 / np.maximum(full_scale, 1e-300), 0)
    conventional, one = np.array(cal["conventional"]["matrix"]), [1.0] * cal["offset"]
    taus, radii = (np.array(features.get(key, [])) for key in ("creep_secs", "play_radii"))
    keep = {"stored_samples": 0, "creep_secs": 0, "play_radii": 0, **cal.get("keep_secs", {})}
    last = None
    for time, s in zip(samples[:, 0], samples[:, 1:]):
        step = np.inf if last is None else time - last
        begins = {memory: step > max(secs, cal["gap_secs"]) for memory, secs in keep.items()}
        if begins["stored_samples"]:
            history, stays, kept = [], True, -np.inf
        history = history if stays else history[:-1]
        stays = time - kept >= cal["history_step_secs"]
        kept = time if stays else kept
        history.append((time, s, weights * (conventional @ np.append(s, one))))
        row = [s]
        for look_back in features["look_backs"]:
            young = [h for h in reversed(history) if time - h[0] <= look_back["t_th_secs"]]
            far = (h[1] for h in young if ((h[2] - history[-1][2]) ** 2).sum() >= look_back["f_th"] ** 2)
            row.append(next(far, s))
        for lag in features.get("fixed_lags_secs", []):
            n = sum(time - h[0] >= lag for h in history)
            (start, before, _), (end, after, _) = history[max(n, 1) - 1], history[min(n, len(history) - 1)]
            row.append(before + (time - start - lag) / (end - start) * (after - before) if n else s)
        share = -np.expm1(-step / taus)
        if begins["creep_secs"]:
            creep, weight = np.tile(s, (len(taus), 1)), np.zeros(len(taus))
        elif step > cal["gap_secs"]:
            weight = weight * (1 - share)
        else:
            creep, weight = creep + share[:, None] * (s - creep), weight + share * (1 - weight)
        if begins["play_radii"]:
            play, low, high = np.tile(s, (len(radii), 1)), s, s
        play = np.maximum(s - radii[:, None] * sd, np.minimum(s + radii[:, None] * sd, play))
        low, high = np.minimum(low, s), np.maximum(high, s)
        determined = np.clip((high - low) / np.maximum(radii[:, None] * sd, 1e-300) - 1, 0, 1)
        played = np.minimum(determined, 0 if begins["play_radii"] else played + 0.03)
        known = s + played * (play - s)
        fade = cal.get("fade", {})
        open_range = np.maximum(2 * radii[:, None] * sd - (high - low), radii[:, None] * sd * (1 - played))
        unknown = np.sum(np.array(fade.get("creep_secs", 0 * taus)) * (1 - weight) ** 2)
        unknown += np.sum(np.array(fade.get("play_radii", 0 * open_range)).ravel() * (open_range**2).ravel())
        last, z = time, (s - shift) * inverse
        histories = row[1:] + list(s + weight[:, None] * (creep - s)) + list(known)
        degree = features.get("polynomial", 1)
        monomials = [z[i] * z[j] for i in range(g) for j in range(i, g) if degree > 1] + list(z**3 if degree > 2 else [])
        load = np.zeros(len(cal["axes"]))
        if "compensated" in cal:
            load = np.array(cal["compensated"]["matrix"]) @ np.concatenate([s, *histories, monomials, one])
        x = np.concatenate([z, *((past - s) * inverse for past in histories), monomials])
        for kind, own in cal.get("learned", {}).items():
            x = (x - own["input_shift"]) * own["input_scale" if kind == "kernel" else "input_inverse_scale"]
            if kind == "kernel":
                near = np.exp(-0.5 * ((np.array(own["landmarks"]) - x) ** 2).sum(1) / own["length_scale"] ** 2)
                load = load + own["offset"] + np.array(own["weights"]) @ near
            else:
                for at, layer in enumerate(own["layers"]):
                    x = np.float32(layer["weights"]).astype(float) @ x + np.float32(layer["biases"])
                    x = np.maximum(x, 0) if at + 1 < len(own["layers"]) else x
                load = load + own["target_shift"] + own["target_scale"] * x
        present = conventional @ np.append(s, one)
        faded = min(1 / (1 + unknown**2), 1 if step == np.inf else faded + 0.03)
        yield present + faded * (load - present) if fade else load


if __name__ == "__main__":
    for load in loads(json.load(open(sys.argv[1])), np.loadtxt(sys.argv[2], ndmin=2)):
        print(*map(repr, map(float, load)))
