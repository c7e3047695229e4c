"""Every pose of every committed scene does what a pose must, checked by geometry of the tests' own."""

import copy

import numpy as np
import pytest

from scalar.simulation import SimulationError, plan_poses, simulate
from scalar.simulation.body import Box, Capsule, body_of
from scalar.simulation.world import World
from scalar.units import DEG
from tests.simulation.conftest import scene_config
from tests.simulation.geometry import fan_hits, sensor_frames

ROUNDING = 1e-9  # m; far above that of double precision, far below anything that matters
FAN = 201  # rays a fan is checked with


def test_joints_stay_within_their_limits(scene):
    """Every q is within the joint limits of the robot."""
    limits = scene.workcell.arm.limits
    assert ((scene.q >= limits[:, 0]) & (scene.q <= limits[:, 1])).all()


def test_scans_lie_wholly_on_the_intended_target_plane(scene):
    """The whole fan falls on the target plane that the pose names, in range and not too steep, clear of the edge."""
    sensor = scene.config["sensor"]
    fan = np.linspace(-1, 1, FAN) * sensor["fan_half_angle_deg"] * DEG
    near, far = sensor["range_m"]
    for T, k in zip(sensor_frames(scene.workcell.arm, scene.q), scene.plane_index, strict=True):
        target_plane = scene.workcell.target_planes[k]
        ranges, cosines, points = fan_hits(T, fan, target_plane.normal, target_plane.distance)
        assert near - ROUNDING < ranges.min() and ranges.max() < far + ROUNDING
        assert cosines.min() > np.cos(sensor["incidence_max_deg"] * DEG) - ROUNDING
        within = np.abs((points - target_plane.centre) @ target_plane.axes[:, :2])
        assert (within <= target_plane.size / 2 - scene.config["edge_margin_m"] + ROUNDING).all()
        assert (T[:3, 3] - target_plane.centre) @ target_plane.axes[:, 2] > 0  # from in front


def test_no_target_plane_stands_in_the_beam(scene):
    """Between the sensor and the intended target plane no other target plane is met."""
    fan = np.linspace(-1, 1, FAN) * scene.config["sensor"]["fan_half_angle_deg"] * DEG
    for T, k in zip(sensor_frames(scene.workcell.arm, scene.q), scene.plane_index, strict=True):
        target_plane = scene.workcell.target_planes[k]
        ranges, _, _ = fan_hits(T, fan, target_plane.normal, target_plane.distance)
        for other in scene.workcell.target_planes:
            if other.name == target_plane.name:
                continue
            crossing, _, points = fan_hits(T, fan, other.normal, other.distance)
            on_it = (np.abs((points - other.centre) @ other.axes[:, :2]) < other.size / 2).all(1)
            assert not (on_it & (crossing > 0) & (crossing < ranges)).any()


def test_no_links_touch_at_any_pose(scene):
    """At every pose, links that could touch stay apart: sampled axes are farther off than the radii."""
    arm = scene.workcell.arm
    body = body_of(scene.workcell.nominal, scene.config["body"])
    assert body.pairs  # there is something to collide with
    for q in scene.q:
        for first, second in body.pairs:
            for p, r in _spine(arm, body, q, first):
                for s, t in _spine(arm, body, q, second):
                    gap = np.linalg.norm(p[:, None] - s[None], axis=2).min() - r - t
                    assert gap > -1e-3


def _spine(arm, body, q, link):
    """Yield sampled axes (P, 3) [m] and radii [m] of a link; a box counts as the ball within it."""
    T = np.eye(4)
    if link >= 0:
        T = arm.T_base_0
        for i in range(min(link, arm.n - 1) + 1):
            c, s = np.cos(q[i]), np.sin(q[i])
            turn = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
            T = T @ arm.joint_origin(i) @ turn
        if link >= arm.n:
            T = T @ arm.T_n_flange
        if link > arm.n:
            T = T @ arm.T_flange_sensor
    for solid in body.solids:
        if solid.link != link:
            continue
        if isinstance(solid, Capsule):
            start, end, radius = solid.start, solid.end, solid.radius
        else:
            assert isinstance(solid, Box)
            start = end = solid.centre
            radius = solid.size.min() / 2
        axis = start + np.linspace(0, 1, 60)[:, None] * (end - start)
        yield axis @ T[:3, :3].T + T[:3, 3], radius


def test_self_collision_is_seen():
    """A Panda folded onto its own base touches itself; stretched out it does not."""
    config = scene_config("panda")
    config["poses_per_plane"] = 1
    scene = simulate(config)
    arm = scene.workcell.arm
    with World() as world:
        world.place_arm(arm, body_of(scene.workcell.nominal, config["body"]))
        assert world.touching([0.0, 1.7, 0.0, -3.0, 0.0, 0.5, 0.0]) == "itself"
        assert world.touching([0.0, 0.3, 0.0, -1.2, 0.0, 1.6, 0.0]) is None


def test_poses_are_nested():
    """The first poses of a plane are the same poses when more are asked for, plane by plane."""
    few = plan_poses(scene_config("paper", poses_per_plane={"floor": 3, "wall_x": 5, "wall_y": 2}))
    many = plan_poses(scene_config("paper", poses_per_plane=9))
    for a, b in zip(few.q, many.q, strict=True):
        np.testing.assert_array_equal(a, b[: len(a)])


def test_poses_spread_over_the_workspace(scene):
    """Poses of a plane are not neighbours: each joint covers a good part of what its limits allow."""
    for k in range(len(scene.workcell.target_planes)):
        q = scene.q[scene.plane_index == k]
        span = np.ptp(q[:, [-3, -1]], axis=0) / np.ptp(scene.workcell.arm.limits[[-3, -1]], axis=1)
        assert (span > 0.3).all()


LIMITS = {
    "out of range": ("sensor", {"range_m": [2.0, 2.1]}),
    "incidence too steep": ("sensor", {"incidence_max_deg": 1e-6}),
    "the beam misses the target plane": ("planes", None),
    "the arm touches a target plane": ("body", {"wrist_radius_m": 0.5, "base_radius_m": 0.5}),
}


@pytest.mark.parametrize("reason", LIMITS)
def test_a_hopeless_workcell_is_refused_with_the_reason(reason):
    """If no pose can be found, the message names the plane, the limit that refused most, and a remedy."""
    config = scene_config("paper", candidates_max=20_000)
    key, change = LIMITS[reason]
    if change is None:
        config["planes"][0]["centre_m"] = [50.0, 0.0, 0.0]
    else:
        config[key] = copy.deepcopy(config[key]) | change
    with pytest.raises(SimulationError) as caught:
        plan_poses(config)
    message = str(caught.value)
    assert message.startswith("plane floor: 0 of 12 poses found")
    assert reason in message
    assert "candidates_max" in message
    assert caught.value.exit_status == 2
