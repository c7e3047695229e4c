"""An arm warms up once: of two growths in the course of time, the lesser has no sure name."""

import pytest

from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.naming.warmth_named_twice import SAME_WARMTH, limited_by_same_warmth
from scalar.effects.joint_scale import JointScale
from scalar.effects.restarted_warm_up import RestartedWarmUp
from scalar.effects.thermal_drift import ThermalDrift
from tests.diagnosis.stand_ins import sure_finding

LEAST = 0.6
AGAIN = RestartedWarmUp("time", (0.0, 3000.0), (1800.0, 5000.0), 600.0)
BY_TIME, BY_TEMPERATURE = ThermalDrift("time", 0.0), ThermalDrift("temperature", 20.0)


@pytest.mark.parametrize("drift", [5.0, 40.0], ids=["the drift has less", "the drift has more"])
def test_the_one_with_less_evidence_loses_its_name(drift):
    """Whichever was found first, the one with the larger log odds keeps its confidence."""
    pair = [sure_finding(BY_TIME, drift), sure_finding(AGAIN, 20.0)]
    answers = limited_by_same_warmth(pair, LEAST)
    less = 0 if drift < 20.0 else 1
    assert (answers[less].confidence, answers[less].limit, answers[less].doubtful) == (
        ONE_OF_TWO,
        SAME_WARMTH,
        True,
    )
    assert answers[1 - less].confidence == 0.95


@pytest.mark.parametrize(
    "beside",
    [
        sure_finding(BY_TEMPERATURE, 50.0),
        sure_finding(JointScale(2), 50.0),
        sure_finding(AGAIN, 50.0, doubtful=True),
    ],
    ids=["another temperature", "no growth", "one in doubt"],
)
def test_a_growth_without_a_second_one_in_time_keeps_its_name(beside):
    """A growth with the recorded temperature of the surroundings is another course, and a doubtful name says nothing."""
    answer, other = limited_by_same_warmth([sure_finding(BY_TIME, 20.0), beside], LEAST)
    assert (answer.confidence, other.confidence) == (0.95, 0.95)
