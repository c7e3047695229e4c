"""A name is not sure where a tilt between parallel axes, which every arm has, explains about as much."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.naming.errors_of_assembly import (
    TILT_EXPLAINS_AS_MUCH,
    limited_by_assembly,
)
from scalar.diagnosis.naming.most_confidence import NOT_SURE
from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.effects.joint_coupling import JointCoupling
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.stand_ins import finding_of

LEAST = 0.6
TILT, OTHER_TILT = (AxisNonparallel(joint, coefficients=np.zeros(1)) for joint in (3, 4))
COUPLING, SCALE = JointCoupling(1, 2, coefficients=np.zeros(1)), JointScale(2, coefficients=np.zeros(1))


@pytest.mark.parametrize(
    ("effect", "rivals", "limited"),
    [
        (COUPLING, (TILT,), True),
        (COUPLING, (SCALE, TILT), True),
        (COUPLING, (SCALE,), False),
        (COUPLING, (), False),
        (TILT, (OTHER_TILT,), False),
        (TILT, (COUPLING,), False),
    ],
)
def test_a_name_beside_an_indistinguishable_tilt_is_not_sure(effect, rivals, limited):
    """The tilt itself keeps its confidence: it is there in any case. A limited name is still given, with the tilt beside it."""
    (found,) = limited_by_assembly([replace(finding_of(effect, 0.97), confounded_with=rivals)], LEAST)
    assert not found.doubtful
    assert (found.confidence, found.limit) == ((NOT_SURE, TILT_EXPLAINS_AS_MUCH) if limited else (0.97, ""))
