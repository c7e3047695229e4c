"""A name that is listed with another one, from which the data do not clearly distinguish it, is not sure."""

from typing import Any

import pytest

from scalar.diagnosis.naming.most_confidence import NEARLY_SURE
from scalar.diagnosis.naming.not_distinguished import NOT_DISTINGUISHED, limited_by_listed_rivals
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.stand_ins import sure_finding

NAMED, NAMELESS = JointHarmonic(5, (1,)), UnattributedJoint(5, (Variable("q5", 0.0, 1.0),))


@pytest.mark.parametrize(
    ("rivals", "log_odds", "limited"),
    [
        ((NAMED,), 7.0, True),
        ((NAMED,), 15.0, False),
        ((NAMELESS,), 7.0, False),
        ((), 7.0, False),
    ],
    ids=["another name", "with clear odds", "no other name", "alone"],
)
def test_a_name_that_is_listed_with_another_is_not_sure(rivals: tuple[Any, ...], log_odds, limited):
    """It keeps its name, with less confidence and with the reason."""
    (answer,) = limited_by_listed_rivals([sure_finding(JointScale(5), log_odds, confounded_with=rivals)])
    assert answer.confidence == (NEARLY_SURE if limited else 0.95)
    assert answer.limit == (NOT_DISTINGUISHED if limited else "")
    assert not answer.doubtful
