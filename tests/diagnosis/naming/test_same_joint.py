"""A name that may be a part of another error of the same joint is doubtful, unless its log odds are clear."""

from types import SimpleNamespace
from typing import Any

import pytest

from scalar.diagnosis.naming.most_confidence import NOT_SURE, ONE_OF_TWO
from scalar.diagnosis.naming.same_joint import PART_OF_STRUCTURE, REST_OF_LAG, limited_by_same_joint
from scalar.effects.joint_scale import JointScale
from scalar.effects.pose_lag import PoseLag
from tests.diagnosis.stand_ins import finding_of

LEAST = 0.6
SURE = 0.95


def finding(effect: Any, log_odds: float, structure_there: bool = False) -> Any:
    """Return a sure finding with these log odds [nats], with or without structure at its joint."""
    found = finding_of(effect, SURE)
    grounds = SimpleNamespace(log_odds=log_odds, structure_there=structure_there)
    object.__setattr__(found, "grounds", grounds)
    return found


@pytest.mark.parametrize(("log_odds", "doubtful"), [(10.0, True), (40.0, False)])
def test_a_name_beside_structure_of_its_joint(log_odds, doubtful):
    (answer,) = limited_by_same_joint([finding(JointScale(3), log_odds, structure_there=True)], LEAST)
    assert answer.doubtful is doubtful
    assert answer.confidence == (ONE_OF_TWO if doubtful else SURE)
    assert answer.limit == (PART_OF_STRUCTURE if doubtful else "")


def test_a_name_without_structure_of_its_joint_keeps_its_confidence():
    (answer,) = limited_by_same_joint([finding(JointScale(3), 10.0)], LEAST)
    assert (answer.confidence, answer.limit) == (SURE, "")


@pytest.mark.parametrize(
    ("joint", "log_odds", "most"), [(3, 10.0, NOT_SURE), (3, 40.0, SURE), (2, 10.0, SURE)]
)
def test_a_scale_error_beside_a_lag(joint, log_odds, most):
    """It is doubted where the same joint lags and its log odds are not clear; the lag itself is not."""
    lag, scale = limited_by_same_joint(
        [finding(PoseLag(3), 10.0), finding(JointScale(joint), log_odds)], LEAST
    )
    assert (lag.confidence, scale.confidence) == (SURE, most)
    assert scale.limit == (REST_OF_LAG if most < SURE else "")
    assert not scale.doubtful
