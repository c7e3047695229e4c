"""Errors that are not defects of this program, and the exit status of each kind.

There are two main kinds, because the user does different things about them: the input is at fault
(`InvalidInput`, exit 2: repair the file), or the input is sound and cannot determine the model
(`Undetermined`, exit 3: measure more, or fix more parameters). The simulator has one of its own, `SimulationError`
(exit 2: change the config). An exception that is not derived from `ScalarError` is a defect of this package.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

# Characters of a column or key that are shown: a damaged file may have names of any length.
_LONGEST_PLACE = 200


_LINES = (".yaml", ".yml", ".json", ".urdf", ".xacro", ".xml")
"""Files that are written by hand or by programs line by line; what stands in a line of any other file is a row of a table."""


def printable(text: str) -> str:
    """Return `text` as one line that is safe to print: control characters and line ends become escapes.

    Messages quote what stands in users' files, which may hold anything, terminal escape codes included.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong with an input: where it is, what it is and what to do about it.

    Attributes:
        file: name of the file, as the user knows it.
        message: what is wrong; what to do, in one line.
        row: line number in the file as an editor shows it (the header of a table is line 1), or None.
        column: name of the column, or path of the key (``robot.joints[2].alpha``), or None.
    """

    file: str
    message: str
    row: int | None = None
    column: str | None = None

    def __str__(self) -> str:
        """Return ``poses.csv, row 17, column q3: not a number ('abc'); write radians as 0.123``; a file that is no table has lines."""
        place = self.file
        if self.row is not None:
            place += f", {'line' if self.file.lower().endswith(_LINES) else 'row'} {self.row}"
        if self.column is not None:
            is_table = self.file.endswith((".csv", ".parquet"))
            name = self.column if len(self.column) <= _LONGEST_PLACE else f"{self.column[:_LONGEST_PLACE]}..."
            place += f", column {name}" if is_table else f", {name}"
        return printable(f"{place}: {self.message}")


class ScalarError(Exception):
    """The root of all errors that this package raises on purpose.

    They pass between processes as they are: kinds of them may have arguments other than those of their root.
    """

    exit_status = 1

    def __reduce__(self) -> tuple[Callable[..., ScalarError], tuple[Any, ...]]:
        """Return how another process makes the same error, without its ``__init__``."""
        return _rebuilt, (type(self), self.args, self.__dict__)


def _rebuilt(kind: type[ScalarError], args: tuple[Any, ...], attributes: dict[str, Any]) -> ScalarError:
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(attributes)
    return error


class InvalidInput(ScalarError):
    """The input is at fault; every fault that was found is in `faults`.

    Args:
        faults: one fault or several, in the order in which they are to be read.
    """

    exit_status = 2

    def __init__(self, faults: Fault | Iterable[Fault]) -> None:
        self.faults: tuple[Fault, ...] = (faults,) if isinstance(faults, Fault) else tuple(faults)
        super().__init__(self.faults)

    def __str__(self) -> str:
        """Return one line for each fault."""
        return "\n".join(str(fault) for fault in self.faults)


class Undetermined(ScalarError):
    """The input is sound but cannot determine the model; `reasons`: what is not determined, and what to measure.

    Args:
        reasons: one sentence or several, each a line.
    """

    exit_status = 3

    def __init__(self, reasons: str | Iterable[str]) -> None:
        self.reasons: tuple[str, ...] = (reasons,) if isinstance(reasons, str) else tuple(reasons)
        super().__init__(self.reasons)

    def __str__(self) -> str:
        """Return one line for each reason."""
        return "\n".join(printable(reason) for reason in self.reasons)


class NotConverged(Undetermined):
    """The optimiser stopped before it reached a minimum, or ran into a bound: there is no result to trust."""
