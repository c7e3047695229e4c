"""An effect of several parts wins against single candidates by its number of parts; so candidates are also compared with its strongest part alone."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import FittedState, refit, whitened
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, named_candidates
from scalar.diagnosis.scoring.conditional_scores import parts_of, rivals, rivals_of_strongest_part
from scalar.diagnosis.selection.forward_selection import reconsidered
from scalar.effects import Effect
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, PoseData, make_cell

SERIES = JointHarmonic(2, (1, 3))


def scale_and_third_order(at: PoseData) -> np.ndarray:
    """Return an error of joint 2 that grows with its angle, and a smaller gear error of the third order."""
    error = np.zeros_like(at.q)
    error[:, 1] = 3e-3 * at.q[:, 1] + 1e-3 * np.sin(3 * at.q[:, 1])
    return error


def state_with(*effects: Effect) -> FittedState:
    """Return a workcell whose joint 2 has these two errors, fitted with some effects."""
    dataset = make_cell(Flaws(joints=scale_and_third_order), seed=92, poses_per_plane=20).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    return refit(dataset, model, prepared.free, effects)


def test_a_score_with_the_other_parts_is_that_of_candidate_and_parts_together():
    """The gain follows from least squares with the columns of the rest and of the candidate, computed here from the rows themselves."""
    state = state_with(SERIES)
    candidates = named_candidates(state.dataset)
    columns = CandidateColumns.of(state, candidates)
    own, _ = rivals(state, 0, columns)
    found = {s.effect.key: s for s in rivals_of_strongest_part(state, 0, own, columns)}
    kept = found[JointScale(2).key].other_parts
    assert isinstance(kept, JointHarmonic) and kept.orders == (3,)

    residual, jacobian = (whitened(state.whitening, rows) for rows in state.linearised())
    first, third = (mask for mask, _ in parts_of(state, 0))
    measured = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    scale = np.zeros((len(jacobian), 1))
    scale[:measured] = state.columns_of([JointScale(2)])

    rest, own_columns = jacobian[:, ~(first | third)], jacobian[:, first | third]
    without = residual - own_columns @ state.model.vector[state.free][first | third]

    def left(*column_sets: np.ndarray) -> float:
        """Return the least sum of squares of the rows without the effect, fitted with some columns."""
        return float(np.linalg.lstsq(np.column_stack(column_sets), without, rcond=None)[1][0])

    gain = left(rest) - left(rest, jacobian[:, third], scale)
    assert found[JointScale(2).key].gain == pytest.approx(gain, rel=0.01)


def test_an_effect_with_one_part_has_no_such_rivals():
    """The whole effect is its only part, and its rivals are already compared with it."""
    state = state_with(JointHarmonic(2, (1,)))
    columns = CandidateColumns.of(state, named_candidates(state.dataset))
    assert rivals_of_strongest_part(state, 0, rivals(state, 0, columns)[0], columns) == []


def test_the_right_effect_takes_the_place_of_one_order():
    """Orders 1 and 3 together explain more than a scale error alone. The scale error with order 3 explains more than both, and replaces order 1."""
    state = state_with(SERIES)
    names = {e.key for e in reconsidered(state, named_candidates(state.dataset))[0].effects}
    assert names == {"joint_scale_2", JointHarmonic(2, (3,)).key}
