"""Finds and runs the program, and makes its error messages exceptions."""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import warnings
from pathlib import Path
from typing import Any, Dict, Iterable, List, NamedTuple


class LoopScopeError(Exception):
    """Message of the program. `code` is its exit code: 1 for unusable data or files, 2 for wrong arguments, 3 for unmet limits."""

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


class OpenQuestion(LoopScopeError):
    """The roles of some columns are unclear. `answer` is an example of what `columns=` could say, such as "2=Fz N"."""

    def __init__(self, message: str, code: int, answer: str) -> None:
        super().__init__(message, code)
        self.answer = answer


class LoopScopeWarning(UserWarning):
    """Warning of the program about the data."""


class Output(NamedTuple):
    """What the program printed: its result, and its notes without the warnings."""

    text: str
    notes: List[str]

    def json(self) -> Any:
        return json.loads(self.text)


def program() -> str:
    """Returns the path of the program: LOOPSCOPE if that variable is set, else the one installed with this package, else that on PATH."""
    here = Path(__file__).resolve().parents[1]
    schemes = [sysconfig.get_path("scripts")]
    if hasattr(sysconfig, "get_preferred_scheme"):
        schemes.append(sysconfig.get_path("scripts", sysconfig.get_preferred_scheme("user")))
    folders = [*schemes, str(here / "bin"), str(here / "Scripts")]  # the last two: `pip install --target`
    given = os.environ.get("LOOPSCOPE")
    found = given or shutil.which("loopscope", path=os.pathsep.join(folders)) or shutil.which("loopscope")
    if not found:
        raise FileNotFoundError(
            "the program loopscope was not found; install the wheel of LoopScope, or set LOOPSCOPE to the path of the program"
        )
    return found


def arguments(options: Dict[str, Any]) -> List[str]:
    """Returns options of the command line: `f_th=3` is `--f-th=3`, True is the option alone, None and False leave it out.
    The values of a list are joined by commas. A dict gives NAME=VALUE pairs."""
    words = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if isinstance(value, dict):
            value = [f"{key}={part}" for key, part in value.items()]
        if value is None or value is False:
            continue
        if value is True:
            words.append(option)
        elif name == "auxiliary_reference" and not isinstance(value, str):
            words += [f"{option}={part}" for part in value]
        elif isinstance(value, Iterable) and not isinstance(value, (str, bytes, os.PathLike)):
            words.append(f"{option}={','.join(map(str, value))}")
        else:
            words.append(f"{option}={value}")
    return words


def run(*words: Any, but: Iterable[int] = ()) -> Output:
    """Runs the program with these words as arguments, such as `run("report", "--train", "day1.csv", "--out", "report.html")`.

    Raises LoopScopeError if the exit code is not 0, unless it is one of `but` and the program has printed a result.
    """
    command = [program(), *map(os.fspath, map(_text, words))]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    text, messages = (stream.decode("utf-8", "replace") for stream in (done.stdout, done.stderr))
    notes, errors = [], []
    for line in messages.splitlines():
        line = re.sub("^(loopscope|error): ", "", line)
        if line.startswith(("warning: ", "left out: ")):
            warnings.warn(line.split(": ", 1)[1], LoopScopeWarning, stacklevel=_outside())
        elif line.startswith("note: "):
            notes.append(line.split(": ", 1)[1])
        else:
            errors.append(line)
    if done.returncode and not (done.returncode in but and text.strip()):
        message = re.split(r"\n\n(?:Usage:|For more)", "\n".join(errors))[0].strip()
        message = message or f"the program ended with the code {done.returncode}"
        answer = re.search(r'Answer with --columns "(.*?)"', message)
        if answer:
            raise OpenQuestion(message, done.returncode, answer[1])
        raise LoopScopeError(message, done.returncode)
    return Output(text, notes)


def _text(word: Any) -> Any:
    return word if isinstance(word, os.PathLike) else str(word)


def _outside() -> int:
    """Returns the stack level of the user's code, which a warning names."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").startswith(__package__):
        level, frame = level + 1, frame.f_back
    return level

