"""The grounds of an answer: the numbers that summarise its evidence, from which its confidence is computed. ``diagnosis.json`` lists them with it.

An *answer* is an effect, a flexible term or a variance component that the diagnosis reports.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import VarianceComponent
from scalar.diagnosis.noise.autocorrelation import autocorrelation_p_values, most_significant
from scalar.diagnosis.scoring.ranking import Scored

EFFECT, COMPONENT, STRUCTURE = "effect", "component", "structure"
_LEAST_CHANCE = 1e-30  # smaller p-values count as this one


@dataclass(frozen=True)
class FinalResiduals:
    """What the residuals of the final model show; it is the same for all answers of a diagnosis.

    Attributes:
        poses: Number of poses that were used.
        misfit: Sum of squares of the whitened residuals over their degrees of freedom; 1 if the noise explains them.
        chance: Smallest p-value of their autocorrelation; it is small if structure remains.
        correlated: Whether components of the noise within scans were identified.
        scans: Whether the sensor scans: its points then show its own noise. A tracker or a probe measures single points.
        along: Columns along which they are significantly autocorrelated. ``diagnosis.json`` lists these elsewhere.
    """

    poses: int
    misfit: float
    chance: float
    correlated: bool
    scans: bool
    along: tuple[str, ...] = ()

    @classmethod
    def of(cls, state: FittedState) -> FinalResiduals:
        """Return these numbers for the state with all effects that were found."""
        background = state.background()
        p_values = autocorrelation_p_values(state, background.residual)
        chance = min(p_values.values(), default=1.0)
        return cls(
            poses=state.dataset.n_poses,
            misfit=background.variance,
            chance=min(max(chance, _LEAST_CHANCE), 1.0),
            correlated=bool(state.residuals.measurement.noise_components),
            scans=state.residuals.measurement.scans,
            along=tuple(most_significant(p_values, state.settings.autocorrelation)),
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return the entries of diagnosis.json."""
        return {key: value for key, value in asdict(self).items() if key != "along"}


@dataclass(frozen=True)
class Grounds:
    """The numbers that summarise the evidence for an answer.

    Attributes:
        kind: ``effect``: an effect with a name; ``component``: a variance component; ``structure``: a flexible term.
        log_odds: Log odds of the answer against all other candidates and against no effect at all [nats].
        least_log_odds: The least of these log odds when one fold of the poses is left out, against the nearest rivals [nats]; for a variance
            component the same as ``log_odds``.
        share: The share of the squared residual without the answer that the answer explains; for a variance component, its share of the variance.
        others: Number of other effects that were found, flexible terms included.
        beside_structure: Whether a flexible term was found as well.
        structure_there: Whether the same joint has further errors without a name over its angle: a flexible term, or autocorrelation of the final
            residuals. An effect of one joint may then be only a part of another, unknown error of this joint.
        final_residuals: What the final residuals show.
    """

    kind: str
    log_odds: float
    least_log_odds: float
    share: float
    others: int
    beside_structure: bool
    structure_there: bool
    final_residuals: FinalResiduals

    def to_mapping(self) -> dict[str, Any]:
        """Return the entry of diagnosis.json."""
        own = {key: value for key, value in asdict(self).items() if key != "final_residuals"}
        return own | self.final_residuals.to_mapping()


def grounds_of_effect(
    state: FittedState,
    i: int,
    own: Scored,
    others: Sequence[float],
    least: float,
    final_residuals: FinalResiduals,
) -> Grounds:
    """Return the grounds of effect i of a state.

    Args:
        state: The state with all effects that were found.
        i: Index of the effect.
        own: Its score given the other effects.
        others: Log evidence of every different answer in its place [nats].
        least: Its least log odds when one fold of the poses is left out [nats].
        final_residuals: What the residuals of the state show.
    """
    effect, other_effects = state.effects[i], [*state.effects[:i], *state.effects[i + 1 :]]
    without_a_name = [other for other in other_effects if other.flexible]
    varies_with = {*final_residuals.along, *(name for other in without_a_name for name in other.depends_on)}
    return Grounds(
        kind=STRUCTURE if effect.flexible else EFFECT,
        log_odds=log_odds(own.evidence, others),
        least_log_odds=least,
        share=own.gain / max(own.gain + state.background().sum_of_squares, 1e-300),
        others=len(other_effects),
        beside_structure=bool(without_a_name),
        structure_there=f"q{effect.erring_joint}" in varies_with,
        final_residuals=final_residuals,
    )


def grounds_of_component(
    state: FittedState, components: Sequence[VarianceComponent], final_residuals: FinalResiduals
) -> Grounds:
    """Return the grounds of the likeliest variance component.

    Args:
        state: The state with all effects that were found.
        components: The variance components that were identified, at least one, the likeliest first.
        final_residuals: What the residuals of the state show.
    """
    best, *rest = components
    rows = best.covariance.shape[1]
    odds = log_odds(best.log_likelihood_gain, [c.log_likelihood_gain for c in rest])
    return Grounds(
        kind=COMPONENT,
        log_odds=odds,
        least_log_odds=odds,
        share=1.0 - rows * len(best.covariance) / float(np.einsum("nii->", best.covariance)),
        others=len(state.effects),
        beside_structure=any(effect.flexible for effect in state.effects),
        structure_there=False,
        final_residuals=final_residuals,
    )


def log_odds(own: float, others: Sequence[float]) -> float:
    """Return the log odds of an answer against all other candidates and against no effect at all [nats].

    They would be correct if one of the candidates were the true cause, and all noise were Gaussian.

    Args:
        own: Its log evidence: half the drop of the Bayesian information criterion, less the log of the number of candidates of its kind.
        others: The log evidence of every different answer.
    """
    return -float(np.logaddexp.reduce([-own, *(other - own for other in others)]))
