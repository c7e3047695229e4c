"""A joint's angle that errs periodically, with a number of periods a turn that need not be whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from scalar.effects.wording import number
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

N_WAVES = 3  # number of waves, the slowest included, that describe a periodic error that is no sine
WAVE_STEP = 0.25  # between the orders that are tried, periods a turn


@dataclass(frozen=True, eq=False)
class UnattributedWave(UnattributedJoint):
    """A joint's angle errs periodically in itself. Unlike with an eccentric gear, the number of periods a turn need not be whole.

    Attributes:
        variables: The joint's own angle.
        order: Periods a turn of the slowest wave.
        waves: Number of waves: of this order, twice it, three times it.
    """

    order: float
    waves: int = N_WAVES

    place: ClassVar[str] = "wave"

    @property
    def _shape_in_words(self) -> str:
        return f"has {number(self.order)} periods a turn"

    @property
    def key(self) -> str:
        """Name, joint and order."""
        alone = "_alone" if self.waves == 1 else ""
        return f"{super().key}_wave_{self.order:.3f}{alone}"

    @property
    def coefficient_names(self) -> list[str]:
        """Sine and cosine of each wave."""
        return [f"{f}{k + 1}_{self.joint_unit}" for k in range(self.waves) for f in ("sin", "cos")]

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the waves on the joint."""
        phase = self.order * poses.q[:, self.joint - 1]
        columns = np.empty((self.waves, 2, len(poses)))
        columns[0] = np.sin(phase), np.cos(phase)
        (sine, cosine), before = columns[0], columns[0]
        for wave in columns[1:]:  # of the next multiple of the phase, by de Moivre
            wave[0] = before[1] * sine + before[0] * cosine
            wave[1] = before[1] * cosine - before[0] * sine
            before = wave
        return columns.reshape(-1, len(poses)).T

    def variations(self, scale: float) -> list[Self]:
        """Return waves a little slower and faster."""
        step = scale * WAVE_STEP / 2
        return [replace(self, order=self.order + a * step) for a in (-1.0, -0.5, 0.0, 0.5, 1.0)]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint, variable and order."""
        return super().to_mapping() | {"place": self.place, "order": self.order, "waves": self.waves}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        variables = tuple(Variable.from_mapping(v) for v in mapping["variables"])
        waves = int(mapping.get("waves", N_WAVES))
        return cls(int(mapping["joint"]), variables, float(mapping["order"]), waves)
