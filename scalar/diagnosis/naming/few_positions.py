"""Lower the confidence in names of one joint that stands at few positions, where an independent error at each position explains as much.

On a grid a joint stands at four or seven angles, for example. An error of its angle then consists of as many numbers, whatever its form: those of a
gear of hundreds of teeth are random there. A scale, play and a compliance of the joint together describe most of such numbers: in a simulated
campaign of 169 poses, of which joint 2 stood at six angles, an error of its drive had been called play with 0.98, and the correction made predictions
2.6 times worse. The names of a joint are therefore compared with one free error for each of its positions.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.data.motion import at_few_positions, positions
from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.fit.variance_components import columns_by_place
from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.conditional_scores import background_without, score_together
from scalar.diagnosis.scoring.score_test import Projected, evidence
from scalar.effects import Effect
from scalar.effects.title import only_joint

FREE_ERRORS = "the joint stands at few positions, and an error of its own at each of them explains as much"


def limited_by_few_positions(
    found: Sequence[Finding], state: FittedState, candidates: CandidateSet, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in those of one joint for which free errors at its positions have more log evidence.

    Args:
        found: All findings.
        state: The state with their effects.
        candidates: The candidate set from which they were chosen.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    free = [
        joint
        for joint in at_few_positions(state.dataset.q)
        if lead_of_free_errors(state, joint, candidates) > 0.0
    ]
    return limited_where(
        found, lambda f: _named_joint(f.effect) in free, ONE_OF_TWO, least_confidence, FREE_ERRORS
    )


def lead_of_free_errors(state: FittedState, joint: int, candidates: CandidateSet) -> float:
    """Return the log evidence [nats] by which free errors at the positions of a joint, in place of all its names, lead these names.

    Each part of each name counts as a choice among all candidates. The lead is minus infinity if the joint has no name.

    Args:
        state: The state with all effects.
        joint: From 1.
        candidates: The candidate set from which the names were chosen.
    """
    named = [i for i, effect in enumerate(state.effects) if _named_joint(effect) == joint]
    by_angle = dict(columns_by_place(state.residuals, state.model)).get(f"q{joint}") if named else None
    if by_angle is None:
        return -np.inf
    position = positions(state.residuals.poses.q[:, joint - 1])
    number = int(position.max()) + 1
    left_out = background_without(state, named)
    background = left_out[0]
    at = position[:, None] == np.arange(number)
    columns = whitened(state.whitening, (by_angle[:, :, None] * at[:, None, :]).reshape(-1, number))
    every = np.arange(number)[None]
    gain, dof, _ = Projected.of(background, columns, columns.T @ columns, np.full(number, np.inf)).score(
        every
    )
    free = evidence(background, gain, dof, np.log(state.dataset.q.shape[1]))
    further = sum(len(state.effects[i].parts()) for i in named) - 1  # the first is counted in their score
    own = score_together(state, named, candidates, left_out).evidence - further * np.log(candidates.total)
    return float(free[0]) - own


def _named_joint(effect: Effect) -> int | None:
    """Return the joint, from 1, of which an effect with a name is an error; None if it concerns none or several."""
    return None if effect.flexible else only_joint(effect.target)
