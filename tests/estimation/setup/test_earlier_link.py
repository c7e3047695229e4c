"""A target that is not on the flange: on the base, or on a link that the last joints do not move."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.motion import refuse_without_motion
from scalar.estimation.setup.suspicion import WrongSetup
from tests import kinematics
from tests.robot_configs import robot_mapping
from tests.tracked_targets import TrackedArm, drawn_arm


@pytest.fixture(scope="module")
def arm():
    """Return an arm with errors and a target."""
    return drawn_arm(np.random.default_rng(5), ("A",))


def measured_on_link(arm, link):
    """Return what a tracker measures of a target on a link (1 is the one that joint 1 moves; 0 the base), with angles of all joints beside it."""
    rng = np.random.default_rng(6)
    q = arm.poses(60, rng)
    standing = q.copy()
    standing[:, link:] = 0.0
    return arm.dataset(q, rng, noise=3e-5, q_true=standing, stated={"noise": 3e-5})


@pytest.mark.parametrize(("link", "joints"), [(3, "joints 4 to 6 do"), (5, "joint 6 does")])
def test_a_target_on_an_earlier_link_is_refused(arm, link, joints):
    """Lengths of the last links take up what the joints behind it should have moved; they come out where the table has them without these."""
    with pytest.raises(WrongSetup, match=f"{joints} not move what is measured") as refused:
        calibrate(measured_on_link(arm, link))
    (suspicion,) = refused.value.suspicions
    assert (
        suspicion.what == "earlier_link" and "where the target or the sensor is mounted" in suspicion.sentence
    )


def test_one_of_several_targets_on_an_earlier_link_is_named():
    """Without it the others fit."""
    rng = np.random.default_rng(12)
    arm = drawn_arm(rng, ("A", "B", "C"))
    q = arm.poses(40, rng)
    standing = q.copy()
    standing[:, 3:] = 0.0
    dataset, on_link = (
        arm.dataset(q, np.random.default_rng(2), noise=3e-5, q_true=true) for true in (q, standing)
    )
    of_c = (dataset.point_columns["target"] == dataset.targets.index("C"))[:, None]
    mixed = replace(dataset, points=np.where(of_c, on_link.points, dataset.points))
    with pytest.raises(WrongSetup, match="target C does not move as the other targets do"):
        calibrate(mixed)


def test_it_is_named_where_no_length_can_take_that_up():
    """A target on the upper arm of a large robot."""
    large = TrackedArm.drawn(np.random.default_rng(5), ("A",), "ur10e", 1)
    with pytest.raises(WrongSetup, match="joints 3 to 6 do not move what is measured") as refused:
        calibrate(measured_on_link(large, 2))
    (suspicion,) = refused.value.suspicions
    assert suspicion.what == "earlier_link"


def test_a_target_on_the_base_is_refused(arm):
    """It stays in its place, to the noise, while the flange moves."""
    with pytest.raises(InvalidInput, match=r"stay in one place to 0.05.*nests\.csv"):
        calibrate(measured_on_link(arm, 0))


def test_one_of_several_targets_that_stays_is_named():
    """The others move."""
    rng = np.random.default_rng(8)
    dataset = drawn_arm(rng, ("A", "B")).dataset(drawn_arm(rng, ("A", "B")).poses(40, rng), rng, noise=3e-5)
    points = dataset.points.copy()
    of_b = dataset.point_columns["target"] == dataset.targets.index("B")
    points[of_b] = [1.0, 0.2, 0.3] + 5e-5 * rng.normal(size=(of_b.sum(), 3))
    with pytest.raises(InvalidInput, match="target B stays in one place"):
        calibrate(replace(dataset, points=points))


def test_an_arm_that_turns_its_tool_about_a_fixed_point_is_accepted():
    """The point on the tool stays in its place by intention: some place on the flange hardly moves."""
    rng = np.random.default_rng(9)
    robot = robot_mapping("vs060")
    geometry = np.array([[j.get(kind, 0.0) for j in robot["joints"]] for kind in kinematics.PARAMETER_KINDS])
    arm = drawn_arm(rng, ("A",))
    q = np.tile([0.2, 0.3, 1.4, 0.0, 0.5, 0.0], (30, 1))
    q[:, 3:] += rng.uniform(
        -1.0, 1.0, (30, 3)
    )  # the axes of this wrist meet in one point, where the tool's is put
    T = kinematics.chain(geometry, q) @ arm.T_n_flange
    centre = kinematics.chain(geometry, q)[:, :3, 3]
    wrist = np.linalg.lstsq(
        (T[:, :3, :3] - T[:, :3, :3].mean(axis=0)).reshape(-1, 3),
        -(T[:, :3, 3] - T[:, :3, 3].mean(axis=0)).ravel(),
        rcond=None,
    )[0]
    assert np.isfinite(centre).all()
    dataset = arm.dataset(q, rng, noise=3e-5)
    fixed = T[:, :3, 3] + T[:, :3, :3] @ wrist + 3e-5 * rng.normal(size=(30, 3))
    refuse_without_motion(replace(dataset, points=fixed))
