"""What is suspected to be wrong in the description of a set-up, and the refusal of a dataset for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from scalar.errors import Fault, InvalidInput
from scalar.geometry.robot import Robot
from scalar.units import MM


@dataclass(frozen=True, eq=False)
class Suspicion:
    """Something in the description of the set-up that is suspected to be wrong.

    Attributes:
        what: As in ``Alternative``; ``known_plane``, ``plane_guess``, ``robot``, ``sensor_pose``, ``orientation`` or ``noise`` if a fit ended
            implausibly; ``unrelated_rows`` if measurements and joint angles have nothing to do with one another; ``points`` if points lie off the
            line of their scan; ``copies`` if rows are copies of others; ``rounded_angles`` or ``rounded_points``; ``column`` if one may be
            misspelt, or has another unit or sign; ``motion`` if several joints never move; ``readings`` if rows repeat the angles of the row before;
            ``run`` if poses that follow each other were set aside; ``order`` if nothing states the order in which the poses were measured;
            ``computed`` if positions were hardly measured; ``joint_reading`` if a sign or zero explains why a fit ended implausibly;
            ``other_side`` if poses that were set aside are alike; ``stretched_lengths`` if all lengths come out too long or short by a few percent;
            ``stretched_axis`` if one measured coordinate does; ``stuck_joint`` if a joint was not logged at poses that were set aside.
        where: What it concerns, as a person names it.
        sentence: What is suspected, with the figures, and what to do.
        rms_before: Residual with the set-up as described [m], or None if no fit was possible.
        rms_after: Residual with the alternative [m], or None if none was tried.
        robot: The corrected robot if the table of joints alone is at fault, else None.
        file: The file that has to be corrected; empty if ``where`` is its name, or if it is dataset.yaml.
    """

    what: str
    where: str
    sentence: str
    rms_before: float | None = None
    rms_after: float | None = None
    robot: Robot | None = None
    file: str = ""

    @property
    def file_at_fault(self) -> str:
        """Return the name of the file that has to be corrected, with which the message begins."""
        return self.file or (self.where if self.where.endswith(".csv") else "dataset.yaml")

    def to_mapping(self) -> Mapping[str, Any]:
        """Return the entry of ``setup`` in diagnosis.json."""
        return {
            "what": self.what,
            "where": self.where,
            "rms_before_mm": None if self.rms_before is None else self.rms_before / MM,
            "rms_after_mm": None if self.rms_after is None else self.rms_after / MM,
        }


class WrongSetup(InvalidInput):
    """The data contradict the set-up that dataset.yaml describes, and one other reading of it explains them.

    Attributes:
        suspicions: What is suspected, the likeliest first.
    """

    def __init__(self, suspicions: tuple[Suspicion, ...]) -> None:
        self.suspicions = suspicions
        super().__init__([Fault(s.file_at_fault, s.sentence) for s in suspicions])


def in_mm(length: float) -> str:
    """Return a length [m] in millimetres, with two digits or as a whole number."""
    return f"{length / MM:.0f}" if length > 10 * MM else f"{length / MM:.2g}"
