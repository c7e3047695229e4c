"""Effects that imitate one another are sure only where the data distinguish them: curves over one angle, base and joints under one weight."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.diagnosis import diagnose
from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.naming.akaike_rivals import akaike_weight, compared_by_akaike
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.effects.torque_compliance import TorqueCompliance
from tests.diagnosis.stand_ins import scored
from tests.effects.injected import Flaws, PoseData, make_cell
from tests.estimation.test_data_sheet_priors import workcell
from tests.kinematics import joint_names

LIMITS = np.array([2.5, 1.2, 1.2, 2.5, 1.6, 2.5])  # rad


def tracked(seed: int, error, most: float, count: int = 120) -> Dataset:
    """Return a tracked arm whose joint 3 is measured up to ``most`` [rad] from its zero, and stands where its angle plus ``error`` of it says."""
    q = np.random.default_rng(seed).uniform(-1, 1, (count, 6)) * np.where(np.arange(6) == 2, most, LIMITS)
    stood = q.copy()
    stood[:, 2] += error(q[:, 2])
    dataset, _ = workcell(seed, stood)
    return replace(dataset, poses=dataset.poses.assign(**dict(zip(joint_names(6), q.T, strict=True))))


def gear(angle):
    """Return the error [rad] of a gear of two orders."""
    return 1.5e-3 * np.sin(angle + 0.2) + 5e-4 * np.sin(2 * angle + 0.1)


def scaled(angle):
    """Return an error [rad] in proportion to the angle."""
    return 1.5e-3 * angle


def found(dataset: Dataset) -> dict[str, float]:
    """Return the confidence of each name that a diagnosis gives to joint 3, and 0 for each that it lists as confounded."""
    findings = diagnose(dataset).findings
    named = {like.name: 0.0 for f in findings for like in f.confounded_with}
    return named | {f.effect.name: f.confidence for f in findings if f.effect.target.get("joint") == 3}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4])
def test_two_orders_over_a_part_of_a_turn_are_not_surely_a_scale(seed):
    """Over 1.2 rad to either side, a scale and one order fit as two orders do: none of the names is sure, and the harmonics are among them."""
    names = found(tracked(seed, gear, most=1.2))
    assert "joint_harmonic" in names and names.get("joint_scale", 0.0) < 0.8


@pytest.mark.slow
@pytest.mark.parametrize(("most", "is_sure"), [(0.5, False), (2.0, True)])
def test_a_scale_is_sure_where_the_joint_moves_far_enough(most, is_sure):
    """Half a radian to either side of its zero does not distinguish a scale from harmonics, and both are stated; two radians do."""
    names = found(tracked(5, scaled, most))
    assert (names["joint_scale"] >= 0.8) == is_sure
    assert ("joint_harmonic" in names) != is_sure


def background() -> Background:
    """Return the residual of a model with one parameter: 41 rows, the sum of whose squares is 50 and which leave 40 degrees of freedom."""
    residual, column = np.zeros(41), np.ones(41)
    residual[:2] = 5.0, -5.0
    return Background.of(residual, column[:, None], 41, 1)


def test_a_further_coefficient_of_the_same_joints_curve_counts_as_one_nat():
    """Among curves over one angle the weights are Akaike's, computed here from the residual sums of squares; other candidates keep their evidence."""
    own = replace(scored(JointScale(2), evidence=12.0, dof=1), gain=20.0)
    order_1 = replace(scored(JointHarmonic(2, (1,)), evidence=9.0, dof=2), gain=20.5)
    orders = replace(scored(JointHarmonic(2, (1, 2)), evidence=4.0, dof=4), gain=15.0)
    elsewhere = replace(scored(JointHarmonic(3, (1,)), evidence=11.5, dof=2), gain=20.5)
    play = replace(scored(JointBacklash(2, by="approach"), evidence=11.0, dof=2), gain=20.5)
    ranking = compared_by_akaike(own, [elsewhere, play, order_1, orders], background())

    criterion = {dof: 40 * np.log(50 - gain) + 2 * dof for dof, gain in [(1, 20.0), (2, 20.5), (4, 15.0)]}
    weights = {dof: np.exp(-(value - criterion[1]) / 2) for dof, value in criterion.items()}
    assert [s.effect for s in ranking] == [elsewhere.effect, order_1.effect, play.effect, orders.effect]
    assert ranking[1].evidence == pytest.approx(12.0 + np.log(weights[2]))
    assert akaike_weight(own, ranking) == pytest.approx(weights[1] / sum(weights.values()))


def test_a_curve_that_fits_better_and_a_flexible_one_do_not_raise_an_effect():
    """A longer curve that is ahead gets the effect's evidence or keeps more; without other curves, the weight is 1."""
    own = replace(scored(JointScale(2), evidence=5.0, dof=1), gain=20.0)
    ahead = replace(scored(JointHarmonic(2, (1,)), evidence=2.0, dof=2), gain=30.0)
    far_ahead = replace(ahead, evidence=7.0)
    assert [s.evidence for s in compared_by_akaike(own, [ahead], background())] == [5.0]
    assert [s.evidence for s in compared_by_akaike(own, [far_ahead], background())] == [7.0]
    assert akaike_weight(own, [replace(ahead, effect=JointHarmonic(3, (1,)))]) == 1.0


def test_the_number_of_joints_does_not_favour_the_base():
    """A joint that explains nearly as much as the base gets the weight that the residuals give it; compliances of one name and target count once."""
    own = replace(scored(BaseCompliance((2, 3), True), evidence=12.0, dof=4), gain=20.0)
    joint = replace(scored(JointCompliance(((2, 2), (2, 3))), evidence=6.0, dof=4), gain=19.0)
    again = replace(joint, effect=JointCompliance(((2, 2),)), evidence=2.0)
    other_base = replace(own, effect=BaseCompliance((2, 3)), evidence=10.0)
    ranking = compared_by_akaike(own, [other_base, joint, again], background())

    odds = (30.0 / 31.0) ** (40 / 2)  # of the joint against the base: the ratio of their likelihoods
    assert [s.evidence for s in ranking[:2]] == pytest.approx([12.0 + np.log(odds)] * 2)
    assert akaike_weight(own, ranking) == pytest.approx(1 / (1 + odds))


def test_a_link_alone_and_an_eccentric_gear_are_one_curve():
    """A joint that gives way under its own link alone is as likely as the first order of its gear that explains the same; with a further link it is
    not compared, and neither is the gear of another joint.
    """
    own = replace(scored(JointCompliance(((2, 2),)), evidence=12.0, dof=2), gain=20.0)
    gear_of_it = replace(scored(JointHarmonic(2, (1,)), evidence=6.0, dof=2), gain=20.0)
    assert akaike_weight(own, compared_by_akaike(own, [gear_of_it], background())) == pytest.approx(0.5)
    assert akaike_weight(gear_of_it, compared_by_akaike(gear_of_it, [own], background())) <= 0.5
    for effect, rival in (
        (JointCompliance(((2, 2), (2, 3))), gear_of_it),
        (own.effect, replace(gear_of_it, effect=JointHarmonic(3, (1,)))),
    ):
        alone = replace(own, effect=effect)
        assert akaike_weight(alone, compared_by_akaike(alone, [rival], background())) == 1.0


@pytest.mark.slow
def test_an_eccentric_gear_of_a_horizontal_axis_is_not_surely_a_joint_that_sags():
    """Once a turn at joint 2: the name is not sure, whichever it is, and the other one is listed with it."""

    def eccentric(at: PoseData) -> np.ndarray:
        error = np.zeros_like(at.q)
        error[:, 1] = 6e-4 * np.sin(at.q[:, 1] + 0.9)
        return error

    findings = diagnose(make_cell(Flaws(joints=eccentric), seed=12, poses_per_plane=30).dataset).findings
    (finding,) = findings
    names = {finding.effect.name, *(like.name for like in finding.confounded_with)}
    assert names >= {"joint_compliance", "joint_harmonic"} and finding.confidence < 0.8


def test_a_joint_that_gives_way_is_one_cause_however_it_is_described():
    """By its measured torque a joint's compliance is as sure as the evidence says, although the weight of the arm explains as much."""
    own = replace(scored(TorqueCompliance((2,)), evidence=12.0, dof=1), gain=20.0)
    by_weight = replace(scored(JointCompliance(((2, 2),)), evidence=6.0, dof=1), gain=20.0)
    assert compared_by_akaike(own, [by_weight], background()) == [by_weight]
    assert akaike_weight(own, [by_weight]) == 1.0
