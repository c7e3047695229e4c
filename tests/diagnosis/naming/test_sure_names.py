"""Names are not sure with unmodelled structure, with several orders, and where they lead by less than is usual for their kind."""

import numpy as np
import pytest

from scalar.diagnosis.naming import several_orders, usual_odds, weight_and_structure
from scalar.diagnosis.naming.most_confidence import NEARLY_SURE
from scalar.diagnosis.naming.several_orders import limited_by_several_orders
from scalar.diagnosis.naming.usual_odds import limited_by_usual_odds
from scalar.diagnosis.naming.weight_and_structure import limited_by_structure
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.flexible.measured_space import UnattributedSpace
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_coupling import JointCoupling
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.effects.plane_bow import PlaneBow
from tests.diagnosis.stand_ins import sure_finding

LEAST, SURE, FEW, MANY = 0.6, 0.95, 60, 300


def gear(*orders):
    """Return harmonics of joint 3."""
    return JointHarmonic(3, orders, coefficients=np.zeros(2 * len(orders)))


JOINTS, BASE, SCALE = JointCompliance(((2, 2),)), BaseCompliance((2, 3), True), JointScale(4)
SPACE = UnattributedSpace("strain")
NAMELESS = sure_finding(SCALE, doubtful=True)
SHRUNK = gear(1, 2, 3).with_term_std([1e-5] * 3)


@pytest.mark.parametrize(
    ("effect", "log_odds", "others", "n_poses", "limited"),
    [
        (JOINTS, 10.0, [NAMELESS], MANY, True),
        (BASE, 10.0, [NAMELESS], MANY, True),
        (JOINTS, 30.0, [NAMELESS], FEW, True),
        (JOINTS, 30.0, [NAMELESS], MANY, False),
        (JOINTS, 10.0, [sure_finding(SCALE)], FEW, False),
        (SCALE, 10.0, [NAMELESS], FEW, False),
        (BASE, 10.0, [sure_finding(SPACE)], FEW, False),
    ],
    ids=[
        "unclear",
        "base",
        "few poses",
        "clear",
        "only names beside",
        "not of the weight",
        "of the instrument",
    ],
)
def test_what_gives_way_is_not_sure_beside_structure_without_a_name(
    effect, log_odds, others, n_poses, limited
):
    """It keeps its name, with a confidence below that of a sure one, unless many poses show it clearly; the others keep theirs."""
    answer, *rest = limited_by_structure([sure_finding(effect, log_odds), *others], n_poses, LEAST)
    expected = (NEARLY_SURE, weight_and_structure.A_PART_OF_IT) if limited else (SURE, "")
    assert (answer.confidence, answer.limit, answer.doubtful) == (*expected, False)
    assert rest == others


@pytest.mark.parametrize(
    ("effect", "others", "limited"),
    [
        (gear(2), [NAMELESS], False),
        (gear(2, 4), [], False),
        (gear(2, 4), [NAMELESS], True),
        (gear(1, 6), [sure_finding(BASE)], True),
        (gear(2, 6), [sure_finding(BASE)], False),
        (gear(1, 6), [sure_finding(SCALE)], False),
        (gear(5, 6, 10), [], True),
        (SHRUNK, [NAMELESS], False),
    ],
    ids=[
        "one",
        "two",
        "beside structure",
        "with the first",
        "without it",
        "no weight",
        "three",
        "all orders",
    ],
)
def test_several_orders_are_not_sure(effect, others, limited):
    """Three orders chosen one by one are never sure; two are not beside unmodelled structure, or with the first beside what gives way."""
    answer, *rest = limited_by_several_orders([sure_finding(effect), *others], LEAST)
    expected = (NEARLY_SURE, several_orders.ANOTHER_FORM) if limited else (SURE, "")
    assert (answer.confidence, answer.limit, answer.doubtful) == (*expected, False)
    assert rest == others


def bow(plane):
    """Return a bowed plane."""
    return PlaneBow(plane, (0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("effect", "log_odds", "others", "limited"),
    [
        (JointCoupling(3, 2), JointCoupling.usual_odds - 1, [], True),
        (JointCoupling(3, 2), JointCoupling.usual_odds + 1, [], False),
        (JointCoupling(3, 2), JointCoupling.usual_odds - 1, [sure_finding(JointCoupling(5, 4), 50.0)], True),
        (bow("floor"), PlaneBow.usual_odds - 1, [], True),
        (bow("floor"), PlaneBow.usual_odds - 1, [sure_finding(bow("wall"), 50.0)], False),
        (SCALE, -5.0, [], False),
    ],
    ids=["below", "above", "not borne out", "one bow", "two bows", "a kind without usual odds"],
)
def test_a_name_with_unusually_small_odds_is_not_sure(effect, log_odds, others, limited):
    """Below the odds that are usual for its kind a name is not sure, unless a fellow bears it out where its kind allows that."""
    answer, *rest = limited_by_usual_odds([sure_finding(effect, log_odds), *others], LEAST)
    expected = (NEARLY_SURE, usual_odds.LEADS_BY_LITTLE) if limited else (SURE, "")
    assert (answer.confidence, answer.limit, answer.doubtful) == (*expected, False)
    assert rest == others
