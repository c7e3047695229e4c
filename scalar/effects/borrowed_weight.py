"""Effects of the arm's weight that look as another effect of the same weight does.

The masses of the links are not known, so the way in which a moment depends on the pose is fitted together with the compliance. Two effects of one
weight are then hard to distinguish: where joint 2 gives way, the base may tilt as much under the same moment, and the fit makes up for what is left.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from scalar.effects.consequence import LEAST_HARM
from scalar.effects.effect import Effect
from scalar.effects.wording import length
from scalar.geometry.se3 import Array


@runtime_checkable
class BorrowsWeight(Protocol):
    """An effect whose coefficients can be taken from another effect of the same weight."""

    def under_the_weight_of(self, other: Effect) -> list[tuple[str, Array]]:
        """Return the coefficients ``(e,)`` with which this effect acts if it bears the weight that another bears, and gives way as much.

        Args:
            other: With fitted coefficients.

        Returns:
            One pair for each place at which the other gives way: its name in a sentence, and the coefficients. No pair if the other bears no such
            weight.
        """
        ...


def consequence_beside(found: str, size: float, error: float) -> str:
    """Return the sentence on an effect that these data cannot distinguish from a part of one that was found.

    Args:
        found: What gives way by what was found.
        size: Root mean square distance [m] by which it may move the sensor unseen.
        error: Error of predicted positions [m] if the effect is present in that size and not in the model.
    """
    off = f"by less than {length(LEAST_HARM)}" if error < LEAST_HARM else f"by about {length(error)}"
    return (
        f"it could move the sensor by {length(size)} (root mean square) unseen, since it would look like a larger or smaller compliance of {found}; "
        f"predicted positions would be off {off}"
    )
