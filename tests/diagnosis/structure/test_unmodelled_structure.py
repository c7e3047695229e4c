"""Which named effects one flexible term may replace, and which are dropped with the flexible term of the same curve."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.structure.dropped_effects import without_effects_of_same_curve
from scalar.diagnosis.structure.replaced_names import groups
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from scalar.effects.joint_coupling import JointCoupling
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.effects.plane_moved import PlaneMoved
from scalar.effects.range_offset import RangeOffset
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.thermal_drift import ThermalDrift
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, PoseData, make_cell

OWN = UnattributedJoint(2, (Variable("q2", 0.0, 1.5),))
OTHER = UnattributedJoint(2, (Variable("q3", 0.0, 1.5),))


def test_one_term_may_stand_for_all_of_a_joint_or_all_that_change_in_time():
    """The groups are all errors of one joint's angle, all changes in time or with a record, and every named effect; no flexible term."""
    effects = [
        JointHarmonic(2, (3,)),
        JointScale(2),
        JointCoupling(5, 4),
        SensorSlip(30.0),
        PlaneMoved("floor", 20.0, None, (0.0, 0.0, 0.0)),
        ThermalDrift("time", 0.0),
        ThermalDrift("temperature", 20.0),
        RangeOffset(),
        OWN,
    ]
    found = list(groups(effects))
    assert found[:2] == [[0, 1], [3, 4, 5, 6]]
    assert found[2:] == [[i] for i in range(8)]


def smooth(at: PoseData) -> np.ndarray:
    """Return errors ``(N, 6)`` [rad] of which that of joint 2 is no harmonic of the third order and no scale."""
    error = np.zeros_like(at.q)
    error[:, 1] = 2e-3 * at.q[:, 1] ** 2
    return error


def third_order(at: PoseData) -> np.ndarray:
    """Return errors ``(N, 6)`` [rad] of which that of joint 2 is a harmonic of the third order."""
    error = np.zeros_like(at.q)
    error[:, 1] = 2e-3 * np.sin(3 * at.q[:, 1])
    return error


@pytest.mark.parametrize(
    ("error", "flexible", "are_dropped"),
    [(smooth, OWN, True), (third_order, OWN, False), (smooth, OTHER, False)],
)
def test_effects_of_the_same_curve_are_dropped_with_a_flexible_term_that_explains_more(
    error, flexible, are_dropped
):
    """A term along a joint's own angle drops that joint's harmonics and scale error if it explains more than they do; nothing else is dropped."""
    cell = make_cell(Flaws(joints=error), seed=7, poses_per_plane=40, points_per_scan=8)
    model, prepared = geometry_fit(cell.dataset)
    named = (JointHarmonic(2, (3,)), JointScale(2), JointCoupling(5, 4))
    state = refit(cell.dataset, model, prepared.free, (*named, flexible))
    left = without_effects_of_same_curve(state).effects
    all_names = {effect.name for effect in named}
    assert {e.name for e in left if not e.flexible} == ({"joint_coupling"} if are_dropped else all_names)
    assert sum(e.flexible for e in left) == 1
