"""In the last fit a term over two angles is small where poses do not show what it is; a term that is there keeps its size."""

import numpy as np
import pytest

from scalar.diagnosis.fit.near_data_sheet import near_data_sheet
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from tests.diagnosis.tracked_arm import fitted_arm, others


@pytest.mark.parametrize("joint", [2, 3, 5])
def test_what_is_not_there_is_small_elsewhere(joint):
    """Of an arm without such an error, the last fit makes less than half as much at poses that were not measured."""
    arm = fitted_arm()
    q = arm.dataset.q
    angles = tuple(Variable.observed(f"q{j}", q[:, j - 1]) for j in (2, 4))
    fitted = arm.refitted([UnattributedJoint(joint, angles)])
    last = near_data_sheet(fitted)
    sizes = []
    for state in (fitted, last):
        (term,) = state.effects
        sizes.append(np.abs(term.own_columns(state.dataset.robot, others()) @ term.coefficients).max())
    assert sizes[1] < 0.5 * sizes[0]
    assert last.effects[0].key == fitted.effects[0].key


def test_a_term_of_one_angle_is_fitted_as_before():
    """Its functions are not alike, so it has the usual prior."""
    term = UnattributedJoint(2, (Variable("q2", 0.0, 1.0),))
    assert term.for_final_fit() is term
