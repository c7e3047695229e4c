"""What a calibration's model may lack of the arm, as far as it is known, for the errors of its predictions.

Kennedy and O'Hagan (Journal of the Royal Statistical Society B 63, 2001) call the difference of the best fitted model from reality its discrepancy.
The covariance of a calibration does not contain it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from scalar.data.poses import Poses
from scalar.geometry.se3 import Array


@dataclass(frozen=True)
class ModelDiscrepancy:
    """What the model of a calibration may lack.

    Attributes:
        excess: Root mean square distance [m] by which the positions of poses are off beyond the noise; zero if the residual is no larger than noise.
        hidden: Returns, from N poses, L independent deviations ``(3 N, L)`` [m] of predicted positions, of one standard deviation each, by effects
            that every arm has and that the measurements do not show; None without such effects.
        hidden_kinds: What the kinds of these effects are called.
        possible: Returns, from N poses, R and a seed, R draws ``(3 N, R)`` [m] of what effects that the model may lack contribute to predicted
            positions, each effect as often as it is probable; None without such effects.
    """

    excess: float = 0.0
    hidden: Callable[[Poses], Array] | None = None
    hidden_kinds: tuple[str, ...] = ()
    possible: Callable[[Poses, int, int], Array] | None = None


NOTHING_LACKS = ModelDiscrepancy()
"""That of a model which is known to lack nothing."""
