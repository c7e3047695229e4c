"""What an answer rests on: the numbers from which its confidence follows, and which diagnosis.json states beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from scalar.diagnosis.autocorrelation import chances
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.ranking import Scored
from scalar.diagnosis.variance_components import VarianceComponent

EFFECT, COMPONENT, STRUCTURE = "effect", "component", "structure"
_LEAST_CHANCE = 1e-30  # smaller p-values count as this one


@dataclass(frozen=True)
class FinalResiduals:
    """What the residuals that are left say of all answers alike.

    Attributes:
        poses: How many were used.
        misfit: Mean square of the whitened residuals, a degree of freedom each; 1 where the noise explains them.
        chance: p-value of the autocorrelation that they show still; small where structure remains.
        correlated: Whether errors are correlated within scans.
    """

    poses: int
    misfit: float
    chance: float
    correlated: bool

    @classmethod
    def of(cls, state: FittedState) -> FinalResiduals:
        """Return it of the state that holds all that was found."""
        background = state.background()
        chance = min(chances(state, background.residual).values(), default=1.0)
        return cls(
            poses=state.dataset.n_poses,
            misfit=background.variance,
            chance=min(max(chance, _LEAST_CHANCE), 1.0),
            correlated=bool(state.residuals.measurement.noise_components),
        )


@dataclass(frozen=True)
class Grounds:
    """What an answer rests on.

    Attributes:
        kind: ``effect``: one with a name; ``component``: a variance component; ``structure``: a flexible term.
        log_odds: For the answer, against everything else that was tried and against nothing at all [nats].
        least_log_odds: The same for the worst case of one fold of the poses left out, against the nearest rivals.
        share: Of the variance without the answer that it explains.
        others: How many other answers were found.
        beside_structure: Whether a flexible term was found as well.
        left: What the final residuals say.
    """

    kind: str
    log_odds: float
    least_log_odds: float
    share: float
    others: int
    beside_structure: bool
    left: FinalResiduals

    def to_mapping(self) -> dict[str, Any]:
        """Return the entry of diagnosis.json."""
        return {key: value for key, value in asdict(self).items() if key != "left"} | asdict(self.left)


def grounds_of_effect(
    state: FittedState, i: int, own: Scored, others: Sequence[float], least: float, left: FinalResiduals
) -> Grounds:
    """Return what effect i of a state rests on.

    Args:
        state: With all that was found.
        i: Which of its effects.
        own: Its score given the others.
        others: Evidence of everything that would answer otherwise in its place [nats].
        least: Its log odds for the worst case of one fold of the poses left out [nats].
        left: Of the state.
    """
    flexible = [effect.flexible for effect in state.effects]
    return Grounds(
        kind=STRUCTURE if flexible[i] else EFFECT,
        log_odds=log_odds(own.evidence, others),
        least_log_odds=least,
        share=own.gain / max(own.gain + state.background().squared, 1e-300),
        others=len(flexible) - 1,
        beside_structure=any(flexible[:i] + flexible[i + 1 :]),
        left=left,
    )


def grounds_of_component(
    state: FittedState, components: Sequence[VarianceComponent], left: FinalResiduals
) -> Grounds:
    """Return what the first of the identified components, at least one, rests on.

    Args:
        state: With all effects that were found. components: The likeliest first. left: Of the state.
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
        left=left,
    )


def log_odds(own: float, others: Sequence[float]) -> float:
    """Return the log odds of an answer among all that was tried and nothing at all [nats].

    They would be right if the truth were among what was tried, and nothing but Gaussian noise in addition.

    Args:
        own: Its evidence: half the drop of the Bayesian information criterion, less the log of how many of a kind were tried.
        others: Those of everything else that would answer otherwise.
    """
    return -float(np.logaddexp.reduce([-own, *(other - own for other in others)]))
