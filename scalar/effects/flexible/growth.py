"""The lengths of one link alone change along a recorded temperature or the clock, while those of the other links do not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.first_steps import first_steps
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.flexible.variable import Variable
from scalar.effects.places import LinkEffect
from scalar.effects.wording import columns_in_words
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_ROWS = [k for k, kind in enumerate(GEOMETRY) if kind in LENGTHS]


@dataclass(frozen=True, eq=False)
class UnattributedGrowth(Unattributed, LinkEffect):
    """Both lengths a and d of one link change in proportion to a column: a motor or a lamp heats this link, or its bolts creep.

    It is the rival of a growth of all lengths, which the same data would otherwise be called.

    Attributes:
        joint: From 1.
        variable: ``temperature``, ``time`` or ``order``.
    """

    joint: int
    variable: Variable

    place: ClassVar[str] = "growth"

    @property
    def depends_on(self) -> list[str]:
        """Return the column that drives the change."""
        return [self.variable.name]

    @property
    def described_as(self) -> str:
        """Return that the lengths of one link change, and with what."""
        return f"a change of the lengths of {self._link} alone with {columns_in_words(self.depends_on)}"

    @property
    def _link(self) -> str:
        """Return which link it is by its two joints, since the number of a link differs between conventions."""
        return (
            f"the link between joints {self.joint - 1} and {self.joint}"
            if self.joint > 1
            else "the base below joint 1"
        )

    @property
    def key(self) -> str:
        """Name, joint and driver."""
        return f"{NAME}_growth{self.joint}_{self.variable.name}"

    @property
    def coefficient_names(self) -> list[str]:
        """The change of each length over half of the column's measured range."""
        return [f"{GEOMETRY[k]}_m" for k in _ROWS]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres."""
        return ["m"] * len(_ROWS)

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the column, scaled to its range, at the lengths of the joint."""
        basis = np.zeros((len(poses), len(GEOMETRY), robot.n_joints, len(_ROWS)))
        for column, k in enumerate(_ROWS):
            basis[:, k, self.joint - 1, column] = self.variable.unit(poses)
        return basis

    @property
    def advice(self) -> list[str]:
        """Return that the link should be looked at, after what any change with this column asks for."""
        look = f"Look for what warms or loosens {self._link} alone: the motor or gear at its end, a lamp, its bolts."
        return [*first_steps(self.depends_on), look]

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that the dependence belongs to one campaign."""
        return f"its dependence on {self.variable.name} is that of one campaign"

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint and driver."""
        return {"place": self.place, "joint": self.joint, "variable": self.variable.to_mapping()}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(int(mapping["joint"]), Variable.from_mapping(mapping["variable"]))
