"""Tests of the Python package. The variable LOOPSCOPE names the program, PYTHONPATH the folder of the package."""

import json
import subprocess
import sys

import numpy as np
import pytest

import loopscope
from loopscope import _tables

AXES = ["Fx", "Mz"]
SENSITIVITY = np.array([[1.0, 0.3, -0.2], [0.1, -0.8, 0.5]])  # gauges per load


def columns(seed, n=300):
    """One recording at 20 Hz: three gauges that follow two loads, with a little hysteresis."""
    rng = np.random.default_rng(seed)
    t = np.arange(n) / 20
    loads = np.column_stack([9 * np.sin(0.8 * t + seed) + 3 * np.cos(2.1 * t), 0.4 * np.cos(1.3 * t + seed)])
    held = loads.copy()
    for k in range(1, n):
        held[k] = np.clip(held[k - 1], loads[k] - [1.5, 0.05], loads[k] + [1.5, 0.05])
    gauges = 0.7 + (loads + 0.2 * held) @ SENSITIVITY + 0.001 * rng.normal(size=(n, 3))
    table = {"t [s]": t, **{f"S{at}": gauges[:, at - 1] for at in (1, 2, 3)}}
    return {**table, "Fx [N]": loads[:, 0], "Mz [N·m]": loads[:, 1]}


TRAIN = {f"run_{seed}": columns(seed) for seed in range(4)}
TEST = columns(9)


def gauges_of(table):
    return np.column_stack([table[f"S{at}"] for at in (1, 2, 3)])


def loads_of(table):
    return np.column_stack([table["Fx [N]"], table["Mz [N·m]"]])


def written(folder):
    """Writes the recordings as CSV, and returns the arguments that name them."""
    for name, table in {**TRAIN, "check": TEST}.items():
        rows = np.column_stack(list(table.values()))
        np.savetxt(folder / f"{name}.csv", rows, "%.17g", ",", header=",".join(table), comments="", encoding="utf-8")
    return ["--train", *(folder / f"{name}.csv" for name in TRAIN), "--test", folder / "check.csv"]


@pytest.fixture(params=["pandas", "numpy"], autouse=True)
def tables(request, monkeypatch):
    """Runs every test with DataFrames, if pandas is there, and with dicts of arrays."""
    if request.param == "numpy":
        monkeypatch.setattr(_tables, "pd", None)
    elif _tables.pd is None:
        pytest.skip("pandas is not installed")
    return request.param


@pytest.fixture(scope="module")
def cal():
    return loopscope.fit(TRAIN, test=TEST, f_th=2, t_th=5)


def test_the_errors_are_those_of_the_command_line(cal, tmp_path):
    command = [loopscope.program(), "fit", "--json", "--f-th", "2", "--t-th", "5", *written(tmp_path)]
    printed = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout)
    for output, key in (("uncompensated", "conventional"), ("compensated", "compensated")):
        for part in ("train", "cv", "test"):
            np.testing.assert_allclose(np.asarray(cal.errors[f"{output} {part}"]), printed[key][f"{part}_rmse"], rtol=1e-9)
    expected = [one["value"] for one in printed["expected_error"]["axes"]]
    np.testing.assert_allclose(np.asarray(cal.errors["expected error"]), expected, rtol=1e-9)
    assert (cal.errors["compensated test"] < cal.errors["uncompensated test"]).all()


def test_the_matrix_is_that_of_least_squares(cal):
    gauges = np.vstack([gauges_of(table) for table in TRAIN.values()])
    loads = np.vstack([loads_of(table) for table in TRAIN.values()])
    design = np.column_stack([gauges, np.ones(len(gauges))])
    solution = np.linalg.lstsq(design, loads, rcond=None)[0].T
    assert (cal.gauges, cal.axes, cal.units) == (["S1", "S2", "S3"], AXES, ["N", "N·m"])
    assert cal.matrix.shape == (2, 3) and cal.offset.shape == (2,) and cal.full_scale.shape == (2,)
    np.testing.assert_allclose(np.column_stack([cal.matrix, cal.offset]), solution, rtol=1e-9, atol=1e-9)
    rmse = np.sqrt(np.mean((gauges @ cal.matrix.T + cal.offset - loads) ** 2, axis=0))
    np.testing.assert_allclose(np.asarray(cal.errors["uncompensated train"]), rmse, rtol=1e-9)
    assert cal.coefficients.shape == (2, len(cal.features)) and cal.features[:3] == cal.gauges


@pytest.mark.parametrize("form", ["dict", "structured", "array", "frame", "path"])
def test_apply_is_the_matrix_product(cal, form, tmp_path, tables):
    if form == "frame" and tables == "numpy":
        pytest.skip("a frame needs pandas")
    written(tmp_path)
    names = list(TEST)
    rows = np.column_stack(list(TEST.values()))
    given = {
        "dict": lambda: TEST,
        "structured": lambda: np.rec.fromarrays(rows.T, dtype=[(name, "<f8") for name in names]),
        "array": lambda: gauges_of(TEST),
        "frame": lambda: _tables.pd.DataFrame(TEST).set_index("t [s]"),
        "path": lambda: tmp_path / "check.csv",
    }[form]()
    found = cal.apply(given, **({"times": TEST["t [s]"]} if form == "array" else {}))
    expected = gauges_of(TEST) @ cal.matrix.T + cal.offset
    labels = ["Fx uncompensated [N]", "Mz uncompensated [N·m]"]
    np.testing.assert_allclose(np.column_stack([found[label] for label in labels]), expected, rtol=1e-9, atol=1e-9)
    error = np.asarray(found["Fx compensated [N]"]) - TEST["Fx [N]"]
    np.testing.assert_allclose(np.sqrt(np.mean(error**2)), np.asarray(cal.errors["compensated test"])[0], rtol=1e-9)
    assert (form == "array") != ("Fx reference [N]" in found)
    assert list(cal.apply(TEST, status=True)["status"])[-1] == "ok"


def test_exports_are_those_of_the_program(cal, tmp_path):
    cal.save(tmp_path / "c.json")
    names = ["sensor.h", "sensor.py", "sensor.npz"]
    ours, theirs = ([tmp_path / folder / name for name in names] for folder in ("ours", "theirs"))
    for folder in ("ours", "theirs"):
        (tmp_path / folder).mkdir()
    cal.export(*ours)
    subprocess.run([loopscope.program(), "export", tmp_path / "c.json", *theirs], check=True, stdout=subprocess.DEVNULL)
    assert [path.read_bytes() for path in ours] == [path.read_bytes() for path in theirs]
    loaded = loopscope.load(tmp_path / "c.json")
    assert np.array_equal(loaded.matrix, cal.matrix) and loaded.data == cal.data
    with pytest.raises(FileExistsError):
        cal.save(tmp_path / "c.json")
    with pytest.raises(loopscope.LoopScopeError):
        cal.export(ours[0])
    cal.export(ours[0], force=True)


def test_the_budget_adds_up(cal):
    budget = cal.budget
    load, output, cause = (np.asarray(budget[name]) for name in ("load", "output", "cause"))
    share = np.asarray(budget["share"])
    assert set(output) == {"uncompensated", "compensated"} and set(AXES) < set(load)
    for axis in AXES:
        for kind in ("uncompensated", "compensated"):
            of = (load == axis) & (output == kind)
            parts, total = share[of & (cause != "total")], share[of & (cause == "total")]
            assert total.shape == (1,) and abs(np.hypot.reduce(parts) / total[0] - 1) < 1e-6


def test_read_gives_what_a_fit_uses(tmp_path):
    written(tmp_path)
    read = loopscope.read([tmp_path / f"{name}.csv" for name in TRAIN])
    assert list(read) == list(TRAIN)
    for name, table in TRAIN.items():
        for column, values in table.items():
            assert np.array_equal(np.asarray(read[name][column]), values), column
    # Milliseconds, kilonewtons and a gap: the program converts and divides.
    t = np.where(np.arange(300) < 150, TEST["t [s]"], TEST["t [s]"] + 90)
    odd = {"t [ms]": 1000 * t, "S1": TEST["S1"], "S2": TEST["S2"], "Fx [kN]": TEST["Fx [N]"] / 1000}
    with pytest.warns(loopscope.LoopScopeWarning):
        first, second = loopscope.read({"odd": odd}).values()
    assert len(first["t [s]"]) == len(second["t [s]"]) == 150
    np.testing.assert_allclose(np.asarray(second["Fx [N]"]), TEST["Fx [N]"][150:], rtol=1e-12)


def test_text_and_dates_reach_the_program():
    days = {name: {**table, "group": np.repeat(name[:4] + str(at % 3), 300)} for at, (name, table) in enumerate(TRAIN.items())}
    assert loopscope.fit(days).result["cross_validation"]["groups"] == 3
    dates = np.datetime64("2024-05-01T10:00:00") + (1000 * TEST["t [s]"]).astype("timedelta64[ms]")
    found = loopscope.inspect({"time": dates, "S1": TEST["S1"], "Fx [N]": TEST["Fx [N]"]})
    assert abs(found["check"]["recordings"][0]["rate_hz"] - 20) < 1e-6


def test_names_that_numpy_saves_in_latin_1_are_read(tmp_path):
    for name, table in TRAIN.items():
        np.save(tmp_path / f"{name}.npy", np.rec.fromarrays(list(table.values()), dtype=[(key, "<f8") for key in table]))
    assert loopscope.fit(tmp_path).axes == AXES


def test_options_are_those_of_the_command_line():
    cal = loopscope.fit(TRAIN, look_back="none", play=[0.2, 0.5], no_offset=True, full_scale=[20, 1], tare=None)
    assert cal.data["features"]["play_radii"] == [0.2, 0.5] and cal.data["features"]["look_backs"] == []
    assert not cal.data["offset"] and np.array_equal(cal.offset, [0, 0]) and list(cal.full_scale) == [20, 1]
    assert loopscope.check(TRAIN, f_th=2)["verdict"] in ("enough", "doubtful", "insufficient")


def test_errors_are_exceptions():
    with pytest.raises(loopscope.LoopScopeError, match="--bogus") as caught:
        loopscope.fit(TRAIN, bogus=3)
    assert caught.value.code == 2 and "Usage" not in str(caught.value)
    with pytest.raises(loopscope.LoopScopeError, match="nowhere.csv") as caught:
        loopscope.fit("nowhere.csv")
    assert caught.value.code == 1
    with pytest.raises(loopscope.LoopScopeError):
        loopscope.load(__file__)
    unnamed = np.column_stack(list(TEST.values()))
    with pytest.raises(loopscope.OpenQuestion) as caught:
        loopscope.fit(unnamed)
    assert caught.value.code == 2 and "=Fz" in caught.value.answer
    answered = loopscope.fit(unnamed, columns="5=Fx N, 6=Mz N·m", f_th=2, t_th=5, force=True)
    assert answered.axes == AXES and answered.matrix.shape == (2, 3)
    for wrong in ({"a/b": TEST}, {"a": 3}):
        with pytest.raises((TypeError, ValueError)):
            loopscope.fit(wrong)


def test_best_lists_the_models_that_it_tried():
    cal = loopscope.best(TRAIN, test=TEST, minutes=0.1, force=True)
    assert np.asarray(cal.models["relative"]).min() < 1 and cal.axes == AXES


def test_the_module_runs_the_program():
    def printed(command):
        return subprocess.run([*command, "--version"], check=True, stdout=subprocess.PIPE).stdout

    assert printed([sys.executable, "-m", "loopscope"]) == printed([loopscope.program()])
