"""Effects of the arm's weight that can hardly be distinguished from another effect of the same weight.

The masses of the links are not known, so the way in which a moment depends on the pose is fitted together with the compliance. If joint 2 gives way,
for example, a base that tilts under the same moment leaves almost the same residual: the fitted masses and the geometry take up the difference.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from scalar.effects.consequence import LEAST_HARM
from scalar.effects.effect import Effect
from scalar.effects.wording import length
from scalar.geometry.se3 import Array


@runtime_checkable
class ActsLikeCompliance(Protocol):
    """An effect of the arm's weight that can act as another effect of the same weight does, with coefficients that follow from those of the other."""

    def giving_way_like(self, other: Effect) -> list[tuple[str, Array]]:
        """Return the coefficients with which this effect deflects as much as another one under the same moments.

        Args:
            other: With fitted coefficients.

        Returns:
            One pair for each place of the other: its name in a sentence (``joint 2``), and the coefficients ``(e,)`` of this effect
            [its ``coefficient_units``]. No pair if the other is no such effect.
        """
        ...


def consequence_if_unobserved(found: str, size: float, error: float) -> str:
    """Return the sentence on an effect that these data cannot distinguish from a part of one that was found.

    Args:
        found: The part of the workcell that gives way according to what was found: ``joint 2``.
        size: Root mean square distance [m] by which it may move the sensor unobserved.
        error: Error of predicted positions [m] if the effect is present in that size and not in the model.
    """
    off = f"by less than {length(LEAST_HARM)}" if error < LEAST_HARM else f"by about {length(error)}"
    return (
        f"it could move the sensor by {length(size)} (root mean square) unseen, since it would look like a larger or smaller compliance of {found}; "
        f"predicted positions would be off {off}"
    )
