"""Tables of Python as files of the program, and files of the program as tables."""

import csv
import os
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Union

import numpy as np

try:
    import pandas as pd
except ImportError:
    pd = None

#: One recording: a DataFrame, a dict of columns, a structured array, or a 2-D array of unnamed columns.
Frame = Any
#: A path of a file or folder, a frame, several of them, or a dict from names to frames.
Recordings = Union[str, "os.PathLike[str]", Frame, Sequence[Any], Mapping[str, Any]]


def table(columns: Dict[str, Any], index: Optional[str] = None) -> Any:
    """Returns columns as a DataFrame if pandas is installed, else as they are: a dict from names to arrays."""
    if pd is None:
        return columns
    made = pd.DataFrame(columns)
    return made.set_index(index) if index else made


def records(rows: List[Dict[str, Any]], index: Optional[str] = None) -> Any:
    """Returns rows with the same keys as a table."""
    names = list(rows[0]) if rows else []
    return table({name: _column([row[name] for row in rows]) for name in names}, index)


def read_csv(path: Path) -> Any:
    """Returns a table that the program wrote. Numbers are those that the program computed, bit by bit."""
    if pd is not None:
        return pd.read_csv(path, float_precision="round_trip")
    with open(path, encoding="utf-8", newline="") as lines:
        names, *rows = csv.reader(lines)
    cells = list(zip(*rows)) or [()] * len(names)
    return {name: _column(column) for name, column in zip(names, cells)}


def _column(cells: Sequence[Any]) -> Any:
    try:
        return np.array([np.nan if cell is None or cell == "" else cell for cell in cells], dtype=float)
    except ValueError:
        return np.array(cells)


def is_path(value: Any) -> bool:
    return isinstance(value, (str, os.PathLike))


def is_frame(value: Any) -> bool:
    """Returns True for a table, and False for a list or dict of tables."""
    if isinstance(value, Mapping):
        return all(not is_path(column) and not is_frame(column) and np.ndim(column) == 1 for column in value.values())
    is_table = hasattr(value, "columns") or getattr(getattr(value, "dtype", None), "names", None)
    return bool(is_table) or isinstance(value, np.ndarray) and value.ndim == 2


def files(recordings: Optional[Recordings], folder: Path) -> Iterator[str]:
    """Returns absolute paths of the recordings. Frames are written to files in the folder first."""
    if recordings is None:
        return
    several: Any = [recordings] if is_path(recordings) or is_frame(recordings) else recordings
    if not isinstance(several, Mapping):
        several = {f"recording_{at}": one for at, one in enumerate(several, 1)}
    for name, one in several.items():
        yield os.path.abspath(one) if is_path(one) else str(write(one, folder, str(name)))


def write(frame: Frame, folder: Path, name: str) -> Path:
    """Writes a frame as .npy, which is exact and quick, or as .csv if it has text or dates."""
    if not name or os.path.basename(name) != name:
        raise ValueError(f"{name!r} cannot be the name of a recording, because it is no name of a file")
    folder.mkdir(parents=True, exist_ok=True)
    if not is_frame(frame):
        raise TypeError(f"{name}: a recording is a table, but this is {type(frame).__name__}")
    if isinstance(frame, np.ndarray) and not frame.dtype.names:
        np.save(folder / f"{name}.npy", frame.astype(float))
        return folder / f"{name}.npy"
    columns = _columns(frame)
    if all(column.dtype.kind in "fiub" for column in columns.values()):
        rows = np.empty(len(next(iter(columns.values()), ())), [(key, "<f8") for key in columns])
        for key, column in columns.items():
            rows[key] = column
        path = folder / f"{name}.npy"
        with open(path, "wb") as out:
            np.lib.format.write_array(out, rows, version=(3, 0))  # names in UTF-8, such as "Mx [N·m]"
        return path
    path = folder / f"{name}.csv"
    with open(path, "w", encoding="utf-8", newline="") as out:
        lines = csv.writer(out)
        lines.writerow(columns)
        lines.writerows(zip(*(_cells(column) for column in columns.values())))
    return path


def _columns(frame: Frame) -> Dict[str, Any]:
    if hasattr(frame, "columns"):
        if any(name is not None for name in frame.index.names) or frame.index.dtype.kind == "M":
            frame = frame.reset_index()
        names, parts = list(map(str, frame.columns)), [frame.iloc[:, at] for at in range(frame.shape[1])]
    else:
        names = list(frame.dtype.names if isinstance(frame, np.ndarray) else frame)
        parts = [frame[name] for name in names]
    if len(set(names)) < len(names):
        raise ValueError(f"several columns have the same name: {', '.join(map(str, names))}")
    return {str(name): np.asarray(part) for name, part in zip(names, parts)}


def _cells(column: Any) -> List[Any]:
    if column.dtype.kind == "M":
        return ["" if np.isnat(cell) else str(cell) for cell in column]
    return ["" if cell is None or cell != cell else cell for cell in column.tolist()]
