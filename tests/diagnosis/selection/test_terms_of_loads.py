"""A harmonic of order 1 that the weight of the joint's own link explains belongs to the compliance of the joint, and is no gear error."""

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.selection.terms_of_loads import with_terms_of_loads
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, PoseData, make_cell


def bent(at: PoseData) -> np.ndarray:
    """Return errors of joints 2 and 3 ``(N, n)`` [rad]: links 2 and 3 weigh on them, and both have a gear error."""
    q, error = at.q, np.zeros_like(at.q)
    error[:, 1] = 8e-4 * np.cos(q[:, 1]) + 5e-4 * np.cos(q[:, 1] + q[:, 2]) + 4e-4 * np.sin(9 * q[:, 1] + 0.3)
    error[:, 2] = 4e-4 * np.cos(q[:, 1] + q[:, 2]) + 6e-4 * np.sin(q[:, 2] + 0.5)
    return error


def after(*effects) -> tuple[FittedState, FittedState]:
    """Return the state with effects, and with their parts that became terms of the load."""
    dataset = make_cell(Flaws(joints=bent), seed=311, poses_per_plane=60).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, effects)
    return state, with_terms_of_loads(state, named_candidates(dataset))


def test_an_order_that_the_weight_of_the_link_explains_becomes_a_term_of_the_compliance():
    """The fit is the same; the order of joint 3, whose weight turns with joint 2 as well, stays, and so does the ninth order."""
    gears = JointHarmonic(2, (1, 9)), JointHarmonic(3, (1,))
    state, found = after(JointCompliance(((2, 3), (3, 3))), *gears)
    compliance, second, third = found.effects
    assert isinstance(compliance, JointCompliance) and compliance.terms == ((2, 2), (2, 3), (3, 3))
    assert isinstance(second, JointHarmonic) and second.orders == (9,)
    assert isinstance(third, JointHarmonic) and (third.joint, third.orders) == (3, (1,))
    residual, before = (one.background().sum_of_squares for one in (found, state))
    assert abs(residual / before - 1.0) < 1e-3


def test_a_whole_effect_may_be_such_a_term():
    _, found = after(JointCompliance(((2, 3), (3, 3))), JointHarmonic(2, (1,)), JointHarmonic(3, (1,)))
    assert [effect.name for effect in found.effects] == ["joint_compliance", "joint_harmonic"]


def test_without_the_load_in_the_model_the_order_stays():
    state, found = after(JointHarmonic(2, (1, 9)), JointHarmonic(3, (1,)))
    assert found is state
    state, found = after(JointCompliance(((3, 3), (3, 4))), JointHarmonic(2, (1, 9)))
    assert found is state  # the compliance that was found is that of joint 3 alone
