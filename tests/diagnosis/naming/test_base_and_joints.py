"""A base that gives way beside joints that do has no sure name if the poses are few and its log odds are unclear."""

import pytest

from scalar.diagnosis.naming.base_and_joints import (
    FEW_POSES,
    SAME_WEIGHT,
    limited_by_joint_compliance,
)
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.stand_ins import sure_finding

LEAST = 0.6
JOINTS, SCALE = JointCompliance(((2, 2),)), JointScale(4)


@pytest.mark.parametrize(
    ("beside", "log_odds", "n_poses", "limited"),
    [
        ([sure_finding(JOINTS)], 10.0, 60, True),
        ([sure_finding(JOINTS)], 30.0, 60, False),
        ([sure_finding(JOINTS)], 10.0, FEW_POSES, False),
        ([sure_finding(SCALE)], 10.0, 60, False),
        ([sure_finding(JOINTS, doubtful=True)], 10.0, 60, False),
        ([], 10.0, 60, False),
    ],
    ids=["few poses", "clear odds", "enough poses", "another effect", "joints in doubt", "alone"],
)
def test_only_an_unclear_base_beside_joints_is_limited(beside, log_odds, n_poses, limited):
    """The base alone is limited, and only where few poses show joints that give way as well and nothing shows it clearly."""
    base = sure_finding(BaseCompliance((2, 3), True), log_odds)
    answer, *others = limited_by_joint_compliance([base, *beside], n_poses, LEAST)
    assert (answer.confidence, answer.limit) == ((ONE_OF_TWO, SAME_WEIGHT) if limited else (0.95, ""))
    assert answer.doubtful == limited
    assert others == beside
