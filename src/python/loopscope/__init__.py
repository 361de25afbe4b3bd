"""Calibrates force/torque sensors, and compensates their hysteresis.

    import loopscope

    cal = loopscope.fit({"day1": frame1, "day2": frame2}, test=frame3, f_th=3)
    cal.errors                     # RMSE and expected error of each axis
    cal.export("sensor.h")         # C code for a robot
    loads = cal.apply(frame3)      # uncompensated and compensated loads

The package runs the program `loopscope`, which is installed with it. Forces are in N, moments in N·m, times in s. Every option of
the command line is a keyword: `--f-th 3` is `f_th=3`, `--no-offset` is `no_offset=True`, `--play 0.1,0.2` is `play=[0.1, 0.2]`.
`loopscope fit --help` lists them. With pandas, tables are DataFrames; without it, dicts from names to NumPy arrays.
"""

import json
import re
import tempfile
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple, Union

import numpy as np

from ._program import LoopScopeError, LoopScopeWarning, OpenQuestion, Output, arguments, program, run
from ._tables import Frame, Recordings, files, is_path, read_csv, records, write

__all__ = [
    "Calibration", "LoopScopeError", "LoopScopeWarning", "OpenQuestion",
    "best", "check", "fit", "inspect", "load", "program", "read", "run",
]

#: Options of `fit` that `check` does not have.
_ONLY_FIT = ("band", "export", "factory", "force", "limits", "traces")


class _Data:
    """Recordings as files. Frames lie in a temporary folder, which is removed with this object."""

    def __init__(self, train: Recordings, test: Optional[Recordings]) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="loopscope-")
        self.folder = Path(self._folder.name)
        self.paths = list(files(train, self.folder / "train"))
        self.words = [f"--train={path}" for path in self.paths]
        self.words += [f"--test={path}" for path in files(test, self.folder / "test")]


class Calibration:
    """A calibration, from `fit`, `best` or `load`.

    Attributes
    ----------
    gauges : names of the gauges
    axes : names of the load axes, a part of Fx Fy Fz Mx My Mz
    units : unit of each axis, N or N·m
    full_scale : (n_axes,) rated load of each axis [N, N·m]
    matrix : (n_axes, n_gauges) matrix of the conventional calibration: load = matrix @ gauges + offset [load unit per gauge unit]
    offset : (n_axes,) load where all gauges are zero [N, N·m]
    features, coefficients : names (n_features,) and coefficients (n_axes, n_features) of the compensated load, whose first columns
        are the gauges; `coefficients` is None for networks and kernels alone
    models : table of the models that `best` tried, else None
    result : what the program printed for this calibration, as a dict; empty for a loaded one
    notes : remarks of the program
    data : content of the calibration file
    """

    def __init__(self, text: bytes, output: Optional[Output] = None, source: Optional[Tuple[_Data, Dict[str, Any]]] = None) -> None:
        self._text, self._source = text, source
        self._budget: Any = None
        self.data: Dict[str, Any] = json.loads(text)
        self.result: Dict[str, Any] = output.json() if output else {}
        self.notes: List[str] = output.notes if output else []
        self.models: Any = None
        self.gauges: List[str] = self.data["gauges"]
        self.axes: List[str] = self.data["axes"]
        self.units: List[str] = self.data["units"]
        self.full_scale = np.array(self.data["full_scale"], dtype=float)
        conventional = np.array(self.data["conventional"]["matrix"], dtype=float)
        n = len(self.gauges)
        self.matrix = conventional[:, :n]
        self.offset = conventional[:, n] if self.data["offset"] else np.zeros(len(self.axes))
        compensated = self.data.get("compensated") or {}
        self.features: List[str] = compensated.get("features", [])
        self.coefficients = np.array(compensated["matrix"], dtype=float) if "matrix" in compensated else None

    def __repr__(self) -> str:
        return f"<Calibration: {' '.join(self.gauges)} -> {' '.join(self.axes)}, {self.data['regressor']}>"

    @property
    def errors(self) -> Any:
        """Table with one row per axis [N, N·m]: RMSE of the uncompensated and of the compensated load on training recordings (train),
        on recordings left out of the fit (cv) and on test recordings (test), and the expected error. NaN where unknown."""
        quality = self.data["quality"]
        expected = {one["axis"]: one.get("value") for one in (quality.get("expected_error") or {}).get("axes", [])}
        rows = []
        for at, (axis, unit) in enumerate(zip(self.axes, self.units)):
            row: Dict[str, Any] = {"axis": axis, "unit": unit}
            for label, key in (("uncompensated", "conventional"), ("compensated", "compensated")):
                for part in ("train", "cv", "test"):
                    values = quality[key].get(f"{part}_rmse")
                    row[f"{label} {part}"] = values[at] if values else None
            rows.append({**row, "expected error": expected.get(axis)})
        return records(rows, "axis")

    @property
    def budget(self) -> Any:
        """Error budget: table with the columns load (an axis, Forces or Moments), output (uncompensated or compensated), cause, `share`
        and `standard error` [% of full scale]. Squares of the shares add up to the square of the total. Computed by `check` at the
        first use, from the recordings of the fit."""
        if self._budget is None:
            if self._source is None:
                raise LoopScopeError("a stored calibration has no recordings; loopscope.check(recordings) gives their error budget", 2)
            data, options = self._source
            options = {key: value for key, value in options.items() if key not in _ONLY_FIT}
            step = self.data.get("history_step_secs")
            if step:
                options.setdefault("history_rate", 1 / step)
            found = _check(data, options)
            if "budget" not in found:
                raise LoopScopeError(f"no error budget: {found.get('no_budget')}", 3)
            self._budget = _budget(found["budget"])
        return self._budget

    def apply(self, data: Union[str, Frame], times: Any = None, **options: Any) -> Any:
        """Returns the loads of one recording: columns `t [s]`, and per axis the reference, if there is one, the uncompensated and the
        compensated load [N, N·m].

        data : a path, a frame with the gauges of the calibration, or an (n, n_gauges) array in their order
        times : (n,) times of an array [s]; a calibration with memory needs them
        options : those of `loopscope apply`, such as `status=True` or `tare="auto"`

        A row that the program cannot use, such as one with NaN, is left out; `t [s]` tells which rows are there.
        """
        with tempfile.TemporaryDirectory(prefix="loopscope-") as folder:
            here = Path(folder)
            if isinstance(data, np.ndarray) and not data.dtype.names:
                if data.ndim != 2 or data.shape[1] != len(self.gauges):
                    raise ValueError(f"the array has the shape {data.shape}; its columns must be {', '.join(self.gauges)}")
                columns = dict(zip(self.gauges, data.T))
                data = columns if times is None else {"t [s]": times, **columns}
            if not is_path(data):
                data = write(data, here, "recording")
            words = [self._file(here), Path(data).absolute(), "--out", here / "loads", *arguments(options)]
            run("apply", *words, but=(1,) if options.get("keep_going") else ())
            return read_csv(next((here / "loads").iterdir()))

    def export(self, *paths: Any, force: bool = False) -> None:
        """Writes the calibration to these files, whose endings select the formats: .h, .rs, .py, .m, .zip, .yaml, .cal, .inc, .csv, .npz,
        .mat, .json. `force=True` overwrites files."""
        with tempfile.TemporaryDirectory(prefix="loopscope-") as folder:
            run("export", self._file(Path(folder)), *paths, *arguments({"force": force}))

    def save(self, path: Any, force: bool = False) -> None:
        """Writes the calibration file (.json), which `load` and the program read. `force=True` overwrites a file."""
        with open(path, "wb" if force else "xb") as out:
            out.write(self._text)

    def _file(self, folder: Path) -> Path:
        path = folder / "calibration.json"
        path.write_bytes(self._text)
        return path


def fit(train: Recordings, test: Optional[Recordings] = None, **options: Any) -> Calibration:
    """Fits a calibration.

    train, test : paths of files or folders, or frames: DataFrames, dicts of columns, structured arrays. Several in a list, or in a dict
        from names to frames. A frame has one row per sample, and columns such as "t [s]", "S1", "Fx [N]"
    options : those of `loopscope fit`, such as `f_th=3`, `play=True`, `full_scale=[200, 200, 400]`, `columns={"Mass": "Fz kgf"}`

    Raises OpenQuestion if the role of a column is unclear, and LoopScopeError for everything else that the program refuses.
    """
    return _fitted("fit", train, test, options)


def best(train: Recordings, test: Optional[Recordings] = None, **options: Any) -> Calibration:
    """Returns the best model; `.models` lists all models that were tried.

    Raises LoopScopeError if the search needs more processor time than `minutes` (10 by default); `force=True` then returns the best so far.
    """
    found = _fitted("best", train, test, options)
    kept = ("name", "blocks", "regressor", "relative", "is_proposed", "is_smallest", "seconds")
    found.models = records([{key: one[key] for key in kept} for one in found.result["tried"]], "name")
    return found


def load(path: Any) -> Calibration:
    """Reads a calibration file (.json)."""
    text = Path(path).read_bytes()
    try:
        is_calibration = json.loads(text).get("format") == "loopscope calibration"
    except (ValueError, AttributeError):
        is_calibration = False
    if not is_calibration:
        raise LoopScopeError(f"{path}: this is no calibration of LoopScope", 1)
    return Calibration(text)


def check(train: Recordings, test: Optional[Recordings] = None, **options: Any) -> Dict[str, Any]:
    """Checks recordings, as `loopscope check --json`: `verdict`, `findings`, `budget`, `budget_in_words`, `remedy_options`, ..."""
    return _check(_Data(train, test), options)


def inspect(recordings: Recordings, **options: Any) -> Any:
    """Returns what the program reads in files or frames, as `loopscope inspect --json`: columns, roles, questions, recordings. One dict
    for a single file, else a list."""
    data = _Data(recordings, None)
    return run("inspect", *data.paths, "--json", *arguments(options), but=(1, 3)).json()


def read(path: Recordings, **options: Any) -> Dict[str, Any]:
    """Returns the recordings of files as the program uses them, as tables by their names: `t [s]`, gauges, and loads in N and N·m. Rows
    are converted, joined, sorted and left out as for a fit. `fit` takes the result."""
    data = _Data(path, None)
    out = data.folder / "read"
    run("inspect", *data.paths, "--json", "--out", out, *arguments(options), but=(3,))

    def order(one: Path) -> List[Any]:
        return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", one.stem)]

    return {one.stem: read_csv(one) for one in sorted(out.iterdir(), key=order)}


def _fitted(job: str, train: Recordings, test: Optional[Recordings], options: Dict[str, Any]) -> Calibration:
    data = _Data(train, test)
    path = data.folder / "calibration.json"
    but = (1,) if options.get("keep_going") else ()
    output = run(job, *data.words, "--json", "--export", path, *arguments(options), but=but)
    return Calibration(path.read_bytes(), output, (data, options))


def _check(data: _Data, options: Dict[str, Any]) -> Dict[str, Any]:
    return run("check", *data.words, "--json", *arguments(options), but=(3,)).json()


def _budget(found: Dict[str, Any]) -> Any:
    rows = []
    for output in ("uncompensated", "compensated"):
        shares = found.get(output) or {}
        for load, one in zip([*found["axes"], *found["pools"]], [*shares.get("axes", []), *shares.get("pools", [])]):
            causes = [(share["cause"], share["square"], share["standard_error"]) for share in one["shares"]]
            causes += [("noise", one["noise"], None), ("unexplained", one["unexplained"], None), ("total", one["total"], None)]
            for cause, square, deviation in causes:
                share = 100 * max(square, 0.0) ** 0.5
                spread = None if deviation is None or not share else 100 * deviation / (2 * max(square, 0.0) ** 0.5)
                rows.append({"load": load, "output": output, "cause": cause, "share": share, "standard error": spread})
    return records(rows)
