"""Fit the nearest rivals of a deflection under a load, where the error of a rival's linear score may decide between the two.

The scores of candidates in an effect's place are computed from columns at the optimum with the effect. Such a linear score has an error in proportion
to what the effect explains. A compliance of some millimetres explains so much that this error may decide between a base and a joint near it: in a
simulated set, the gains of the two fits were 921 and differed by 0.3, but the linear score of the joint was too small by 58, or 27 nats.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.conditional_scores import background_without
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.ranking import Scored
from scalar.diagnosis.scoring.score_test import fall

# Chosen, a share of the gain: a rival whose linear score is smaller by a larger share is no nearer after a fit.
MOST_ERROR = 0.02
FITTED = 2  # chosen: number of rivals that are fitted, those with the most log evidence


def with_fitted_rivals(state: FittedState, i: int, own: Scored, ranking: Sequence[Scored]) -> list[Scored]:
    """Return the scores in an effect's place, best first, in which the nearest rivals have the gain of a fit where that is larger.

    Args:
        state: The state with all effects.
        i: Index of the effect.
        own: Its score.
        ranking: The scores of the candidates in its place, best first.
    """
    effect = state.effects[i]
    if not effect.load:
        return list(ranking)
    near = [s for s in ranking if _may_be_as_good(s, own) and not s.effect.same_answer(effect)]
    fitted = {id(s): _fitted(state, i, own, s) for s in near[:FITTED]}
    return sorted((fitted.get(id(s), s) for s in ranking), key=lambda s: -s.evidence)


def _may_be_as_good(rival: Scored, own: Scored) -> bool:
    """Return whether a rival under the same load has a gain that is smaller by no more than the error of a linear score."""
    alike = rival.effect.load == own.effect.load and not rival.effect.flexible and rival.other_parts is None
    return alike and (1.0 - MOST_ERROR) * own.gain <= rival.gain and rival.evidence < own.evidence


def _fitted(state: FittedState, i: int, own: Scored, rival: Scored) -> Scored:
    """Return the score of a rival with the gain of its fit in place of effect i; its linear score if that gain is smaller or the fit implausible."""
    others = [effect for k, effect in enumerate(state.effects) if k != i]
    instead = state.refitted(merged(others, rival.effect))
    gain = own.gain + state.background().sum_of_squares - instead.background().sum_of_squares
    if gain <= rival.gain or not instead.is_plausible:
        return rival
    without = background_without(state, [i])[0]
    falls = fall(without, np.array([rival.gain, gain]), np.array([rival.dof, rival.dof]))
    return replace(rival, gain=gain, evidence=rival.evidence + 0.5 * float(falls[1] - falls[0]))
