"""An arm on a rail tilts about its carriage, by the weight of what the carriage bears, and not by its travel."""

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.flexible.tilt import UnattributedTilt
from scalar.geometry.robot import Robot
from tests.rail_and_arm import RailAndArm, nominal_mapping, poses
from tests.robot_configs import robot_mapping

RAIL = Robot.from_mapping(nominal_mapping())


def test_the_carriage_stays_where_the_rail_bears_it():
    """The point of the base frame that the rail has carried along does not move, whichever mass tilts the arm."""
    q = poses(20, np.random.default_rng(3))
    screws = BaseCompliance((2, 3, 4)).base_screws(RAIL, Poses.from_arrays(q, {}, RAIL.slides))
    w, v = screws[:, :3], screws[:, 3:]
    place = q[:, :1] * np.array([1.0, 0.0, 0.0])  # the rail runs along x
    moved = v + np.cross(w, place[:, :, None], axis=1)
    assert np.abs(w).max() > 0.1
    np.testing.assert_allclose(moved, 0.0, atol=1e-12)


def test_tilts_do_not_depend_on_the_travel():
    """The same angles at another place of the rail give the same tilt."""
    q = poses(20, np.random.default_rng(3))
    effect = BaseCompliance((2, 3, 4), alike=True)
    here, there = (
        effect.base_screws(RAIL, Poses.from_arrays(at, {}, RAIL.slides))[:, :3]
        for at in (q, q + 0.3 * np.eye(7)[0])
    )
    np.testing.assert_allclose(here, there, atol=1e-12)


def test_the_rail_is_no_lever():
    """The masses of all frames but the rail's are candidates; without a rail, those of all."""
    rng = np.random.default_rng(4)
    on_rail = RailAndArm.drawn(rng).dataset(poses(20, rng), 1e-5, rng)
    assert {e.frames for e in BaseCompliance.candidates(on_rail)} == {(2, 3, 4, 5, 6, 7)}
    arm = Robot.from_mapping(robot_mapping("vs060"))
    on_floor = BaseCompliance((1, 2)).base_screws(arm, Poses.from_arrays(np.ones((3, 6)), {}, arm.slides))
    assert not on_floor[:, 3:].any()


def test_no_tilt_of_an_axis_is_the_same_as_a_tilt_of_the_carriage():
    """The axis of the first joint that turns tilts with the carriage, so it is no rival; those of the joints after it are."""
    rng = np.random.default_rng(4)
    dataset = RailAndArm.drawn(rng).dataset(poses(20, rng), 1e-5, rng)
    rivals = BaseCompliance((2, 3)).imitators(dataset)
    assert {e.joint for e in rivals if isinstance(e, UnattributedTilt)} == {3, 4, 5, 6, 7}
