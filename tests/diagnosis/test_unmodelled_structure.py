"""Which named effects one flexible term may replace, and which are dropped with the flexible term of the same curve."""

import numpy as np
import pytest

from scalar.diagnosis.dropped_effects import without_effects_of_same_curve
from scalar.diagnosis.fitted_state import refit
from scalar.diagnosis.unmodelled_structure import _groups
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
from tests.effects.injected import make_cell

OWN = UnattributedJoint(2, (Variable("q2", 0.0, 1.5),))
OTHER = UnattributedJoint(2, (Variable("q3", 0.0, 1.5),))


def test_one_term_may_stand_for_all_of_a_joint_or_all_that_change_in_time():
    """The groups are all errors of one joint's angle, all changes in time, and every named effect alone; a flexible term is in none."""
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
    groups = list(_groups(effects))
    assert groups[:2] == [[0, 1], [3, 4, 5]]
    assert groups[2:] == [[i] for i in range(8)]


@pytest.mark.parametrize(("flexible", "kept"), [(OWN, {"joint_coupling"}), (OTHER, None)])
def test_effects_of_the_same_curve_are_dropped_with_a_flexible_term(flexible, kept):
    """A term along a joint's own angle drops that joint's harmonics and scale error, and nothing else; a term along another angle drops nothing."""
    dataset = make_cell(seed=7, poses_per_plane=40, points_per_scan=8).dataset
    model, prepared = geometry_fit(dataset)
    named = (JointHarmonic(2, (3,)), JointScale(2), JointCoupling(5, 4))
    state = refit(dataset, model, prepared.free, (*named, flexible))
    left = {effect.name for effect in without_effects_of_same_curve(state).effects if not effect.flexible}
    assert left == (kept or {effect.name for effect in named})
    assert np.count_nonzero([effect.flexible for effect in without_effects_of_same_curve(state).effects]) == 1
