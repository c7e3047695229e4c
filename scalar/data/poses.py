"""What is recorded of each pose besides the measurement, such as joint angles, time, temperature and direction of approach."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from scalar.data.columns_on_demand import ColumnsOnDemand
from scalar.data.moves import joint_angles, moves, moves_in_order
from scalar.errors import Fault, InvalidInput
from scalar.geometry.robot import BoolArray
from scalar.geometry.se3 import Array
from scalar.kernels.chain import turned

if TYPE_CHECKING:
    import pandas as pd


def _numbers(name: str, values: ArrayLike) -> Array:
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInput(Fault("poses", "not numbers", None, name)) from None
    if not np.all(np.isfinite(numbers)):
        raise InvalidInput(Fault("poses", "a number is not finite", None, name))
    return numbers


def _meaning(column: str) -> str:
    """Return in brackets what a column that an effect needs contains; empty for one that its name explains."""
    joint = column.removeprefix("approach")
    if joint != column and joint.isdecimal():
        return f" (1 if joint {joint} arrives with a growing position, -1 if with a falling one)"
    units = {"time": "s", "temperature": "deg C", "payload": "kg"}
    return f" [{units[column]}]" if column in units else ""


def is_joint(column: str) -> bool:
    """Return whether a column holds a joint's angle or travel: q1, q2 and so on."""
    return column.startswith("q") and column[1:].isdigit()


def session_codes(labels: pd.Series) -> Array:
    """Return the session of each pose, ``(N,)`` int64, numbered from 0 in order of first appearance.

    Args:
        labels: ``(N,)``, the column ``session``; where all labels are numbers, 1 and 1.0 are one session.
    """
    import pandas as pd

    try:
        return pd.factorize(labels.astype(float))[0].astype(np.int64)
    except ValueError:
        return pd.factorize(labels)[0].astype(np.int64)


def _columns(
    frame: pd.DataFrame, q: Array, slides: Sequence[bool] | BoolArray, *, ordered: bool
) -> dict[str, Array]:
    """Return the numeric columns of a table of poses but joints, ids and order; with those of the moves to the poses if their order is known."""
    joints = [f"q{i + 1}" for i in range(q.shape[1])]
    # Column by column: ``select_dtypes`` and a selection of several columns build tables, at many times the cost.
    numeric = [c for c, kind in zip(frame.columns, frame.dtypes, strict=True) if kind.kind in "iuf"]
    found = {c: frame[c].to_numpy(dtype=float) for c in numeric if c not in (*joints, "pose", "order")}
    return found | moves(frame, slides, q) if ordered else found


@dataclass(frozen=True, eq=False)
class Poses:
    """N poses as the encoders read them, with what else was recorded.

    Attributes:
        q: ``(N, n)`` [rad; m for a prismatic joint].
        order: ``(N,)``, order of acquisition; infinite for poses after all that were measured.
        columns: Every other numeric column of the table by name, ``(N,)`` each (time [s], temperature [deg C], approach1 ...);
            and the moves to each pose (``scalar.data.moves``), if an order is known.
    """

    q: Array
    order: Array
    columns: Mapping[str, Array]

    @classmethod
    def from_frame(
        cls,
        frame: pd.DataFrame,
        slides: Sequence[bool] | BoolArray,
        *,
        order_is_row: bool,
        q: Array | None = None,
    ) -> Poses:
        """Return the poses of a table with the columns of ``poses.csv``.

        Args:
            frame: The table.
            slides: ``(n,)``, which joints are prismatic. A joint that slides stands still within another distance than one that turns.
            order_is_row: Whether ``order``, if missing, is the row number (for a dataset) or infinite (for a prediction of the state at the end).
            q: ``(N, n)`` [rad, m], the columns q1.. where they have been taken from the table already, or None.
        """
        if "order" in frame:
            order = frame["order"].to_numpy(dtype=float)
        else:
            order = np.arange(len(frame), dtype=float) if order_is_row else np.full(len(frame), np.inf)
        q = joint_angles(frame, len(slides)) if q is None else q
        return cls(
            q,
            order,
            ColumnsOnDemand(partial(_columns, frame, q, slides, ordered="order" in frame or order_is_row)),
        )

    @classmethod
    def of_joints(cls, q: Array) -> Poses:
        """Return poses of which the joint angles ``(N, n)`` [rad, m] alone are known, in this order."""
        return cls(q, np.arange(len(q), dtype=float), {})

    @classmethod
    def from_arrays(
        cls,
        q: ArrayLike,
        columns: Mapping[str, ArrayLike],
        slides: Sequence[bool] | BoolArray,
    ) -> Poses:
        """Return poses to predict for, from arrays; without ``order`` they come after all poses that were measured.

        An ``order`` with a number of its own for each pose also tells how each joint moved to it.

        Args:
            q: ``(N, n)`` [rad; m for a prismatic joint].
            columns: Columns of poses.csv by name, ``(N,)`` each, or one number for all poses; ``approach`` may be ``(N, n)``.
            slides: ``(n,)``, which of the robot's joints are prismatic.

        Raises:
            InvalidInput: An array has another shape, or a value is not a finite number.
        """
        angles = _numbers("q", q)
        if angles.ndim != 2 or angles.shape[1] != len(slides):
            message = f"an array of shape {angles.shape}; the robot needs (poses, {len(slides)})"
            raise InvalidInput(Fault("poses", message, None, "q"))
        given: dict[str, Array] = {}
        for name, values in columns.items():
            numbers = _numbers(name, values)
            if name == "approach" and numbers.shape == angles.shape:
                given |= {f"approach{i + 1}": column for i, column in enumerate(numbers.T)}
            elif numbers.shape in ((), (len(angles),)):
                given[name] = np.broadcast_to(numbers, len(angles))
            else:
                message = f"an array of shape {numbers.shape}; write one number, or ({len(angles)},)"
                raise InvalidInput(Fault("poses", message, None, name))
        order = given.pop("order", np.full(len(angles), np.inf))
        is_sequence = len(np.unique(order)) == len(order) > 1
        return cls(
            angles,
            order,
            {**moves_in_order(angles, order, slides, time=given.get("time")), **given}
            if is_sequence
            else given,
        )

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.q)

    @cached_property
    def turned(self) -> Array:
        """Return the cosine and the sine of each joint angle ``(N, n, 2)``, for the compiled library."""
        return turned(self.q)

    def column(self, name: str) -> Array:
        """Return a column ``(N,)`` by name.

        Raises:
            InvalidInput: The table lacks the column that an effect needs.
        """
        if name not in self.columns:
            raise InvalidInput(
                [
                    Fault(
                        "poses",
                        f"the calibrated effects need the column '{name}'{_meaning(name)}, and it is missing; add it to the table",
                        None,
                        name,
                    )
                ]
            )
        return self.columns[name]

    def approach(self) -> Array | None:
        """Return the directions of approach ``(N, n)``, or None where they are not recorded for every joint."""
        names = [f"approach{i + 1}" for i in range(self.q.shape[1])]
        if any(name not in self.columns for name in names):
            return None
        return np.column_stack([self.columns[name] for name in names])
