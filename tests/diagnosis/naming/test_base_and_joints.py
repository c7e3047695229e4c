"""A base that gives way beside joints that do has no sure name if the poses are few and its log odds are unclear."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

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
from tests.diagnosis.stand_ins import finding_of

LEAST = 0.6
JOINTS, SCALE = JointCompliance(((2, 2),)), JointScale(4)


def found(effect: Any, log_odds: float = 10.0, **more: Any):
    """Return a finding with a confidence of 0.95."""
    grounds: Any = SimpleNamespace(log_odds=log_odds)
    return replace(finding_of(effect, 0.95), grounds=grounds, **more)


@pytest.mark.parametrize(
    ("beside", "log_odds", "n_poses", "limited"),
    [
        ([found(JOINTS)], 10.0, 60, True),
        ([found(JOINTS)], 30.0, 60, False),
        ([found(JOINTS)], 10.0, FEW_POSES, False),
        ([found(SCALE)], 10.0, 60, False),
        ([found(JOINTS, doubtful=True)], 10.0, 60, False),
        ([], 10.0, 60, False),
    ],
    ids=["few poses", "clear odds", "enough poses", "another effect", "joints in doubt", "alone"],
)
def test_only_an_unclear_base_beside_joints_is_limited(beside, log_odds, n_poses, limited):
    """The base alone is limited, and only where few poses show joints that give way as well and nothing shows it clearly."""
    base = found(BaseCompliance((2, 3), True), log_odds)
    answer, *others = limited_by_joint_compliance([base, *beside], n_poses, LEAST)
    assert (answer.confidence, answer.limit) == ((ONE_OF_TWO, SAME_WEIGHT) if limited else (0.95, ""))
    assert answer.doubtful == limited
    assert others == beside
