"""Planned scans fall on the target plane where it ends, and no part of the arm stands in their beam: judged by the tests' own geometry."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.declared import PlaneGuess, description
from scalar.data.description import Description, check_description
from scalar.errors import InvalidInput
from scalar.geometry.robot import fixed_transform_mapping
from scalar.planning.candidates import draw_candidates
from scalar.planning.workcell import Workcell
from scalar.robots import read_arm
from scalar.simulation.collisions import collision_test
from scalar.units import DEG
from tests import kinematics
from tests.random_scene import make_scene

FAN = 15.0 * DEG


@pytest.fixture(scope="module")
def scene():
    """Return a dataset of three planes with a line laser."""
    return make_scene(seed=4, poses_per_plane=4, points_per_scan=10).dataset


def sensor_frames(robot, T_flange_sensor, q):
    """Return the sensor's frames ``(N, 4, 4)`` by the tests' own kinematics."""
    return kinematics.chain(robot.geometry, q, robot.T_base_0) @ robot.T_n_flange @ T_flange_sensor


@pytest.mark.parametrize("radius", [0.2, 0.3])
def test_the_whole_fan_falls_on_a_plane_that_ends(scene, radius):
    """Every ray of every candidate meets its plane within the stated circle, and without a circle some rays fall outside it."""
    spots = {}
    for plane in scene.planes:  # the middle of what is seen of the endless plane
        found = draw(scene, scene.planes, 90)
        own = np.array([scene.planes[k].name == plane.name for k in found.plane])
        spots[plane.name] = on_plane(scene, found, scene.planes)[own]
    planes = tuple(replace(p, centre=spots[p.name].mean((0, 1)), radius=radius) for p in scene.planes)
    found = draw(scene, planes, 90)
    for k, plane in enumerate(planes):
        distance = np.linalg.norm(on_plane(scene, found, planes)[found.plane == k] - plane.centre, axis=-1)
        assert len(distance) >= 3 and np.all(distance <= radius + 1e-9)
        assert np.any(np.linalg.norm(spots[plane.name] - plane.centre, axis=-1) > radius)


def draw(scene, planes, count):
    """Return candidates for these planes, without a test for collisions."""
    workcell = Workcell.of(scene.robot, replace(scene.sensor, noise=1e-4), planes)
    return draw_candidates(workcell, count, np.random.default_rng(0))


def on_plane(scene, found, planes):
    """Return where the first, the middle and the last ray of each scan meet their plane ``(N, 3, 3)`` [m]."""
    T = sensor_frames(scene.robot, scene.sensor.T_flange_sensor, found.q)
    normals = np.array([planes[k].normal for k in found.plane])
    distances = np.array([planes[k].distance for k in found.plane])
    spots = []
    for angle in (-FAN, 0.0, FAN):
        ray = T[:, :3, 0] * np.sin(angle) + T[:, :3, 2] * np.cos(angle)
        reach = (distances - np.sum(T[:, :3, 3] * normals, axis=1)) / np.sum(ray * normals, axis=1)
        spots.append(T[:, :3, 3] + ray * reach[:, None])
    return np.stack(spots, axis=1)


def test_a_plate_out_of_sight_is_refused_with_its_extent(scene):
    """If no ray can reach the circle, the refusal names the plane and the extent as what to check."""
    far = replace(
        scene.planes[0], centre=scene.planes[0].distance * scene.planes[0].normal + 30.0, radius=0.2
    )
    with pytest.raises(InvalidInput, match=f"'{far.name}' from 0 .* its extent"):
        draw(scene, (far, *scene.planes[1:]), 30)


def test_an_arm_that_stands_in_its_own_beam_is_seen():
    """A scan that looks through the middle of the arm's base is refused, and one that looks away from the arm is not: by the distance of the
    rays from the axis of joint 1, between the floor and the shoulder."""
    robot = read_arm("kuka_kr6_r900_sixx").robot
    T_flange_sensor = np.eye(4)
    T_flange_sensor[2, 3] = 0.1
    rng = np.random.default_rng(1)
    q = rng.uniform(*robot.limits.T, (20_000, 6))
    T = sensor_frames(robot, T_flange_sensor, q)
    along = np.linspace(0.05, 0.45, 81)
    ray = T[:, None, :3, 3] + along[:, None] * T[:, None, :3, 2]
    height, aside = ray[..., 2], np.linalg.norm(ray[..., :2], axis=-1)
    through = np.any((aside < 0.02) & (height > 0.05) & (height < 0.3), axis=1)
    outside = (np.linalg.norm(T[:, :2, 3], axis=1) > 0.5) & np.all(aside > 0.5, axis=1)
    away = outside & (np.sum(T[:, :2, 3] * T[:, :2, 2], axis=1) > 0.4)
    assert through.sum() >= 5 and away.sum() >= 5
    with collision_test(robot.to_mapping(), fixed_transform_mapping(T_flange_sensor), []) as tests:
        assert not np.any(tests.sees_past_itself(q[through], FAN, 0.45))
        clear = q[away][tests.free(q[away])]
        assert len(clear) >= 5 and np.mean(tests.sees_past_itself(clear, FAN, 0.45)) > 0.9


def test_an_arm_touches_a_plate_where_the_plate_is_and_not_beside_it():
    """An upright plate that cuts a stretched arm is touched, the same plate two metres aside is not, and a plane without an extent is touched."""
    robot = read_arm("kuka_kr6_r900_sixx").robot
    T_flange_sensor = np.eye(4)
    T_flange_sensor[2, 3] = 0.1
    q = np.deg2rad([[0.0, -45.0, 90.0, 0.0, 0.0, 0.0]])  # the flange is 0.73 m before the base
    wall = {"name": "wall", "normal": [1.0, 0.0, 0.0], "distance": 0.5}
    for centre, free in (([0.5, 0.0, 0.4], False), ([0.5, 2.0, 0.4], True), (None, False)):
        extent = {} if centre is None else {"extent": {"centre": centre, "radius": 0.4}}
        with collision_test(
            robot.to_mapping(), fixed_transform_mapping(T_flange_sensor), [wall | extent]
        ) as tests:
            assert tests.free(q).tolist() == [free]


def test_the_arm_passes_beside_an_upright_plate_and_stays_above_a_flat_one(scene):
    """Some poses reach beyond the plane of a small upright plate, none is behind the plate itself, and none is below a flat one that ends."""
    floor = PlaneGuess("floor", [0, 0, 1], 0.0, centre=[0.3, -0.3, 0.0], radius=0.25)
    plate = PlaneGuess("wall_x", [1, 0, 0], 0.3, centre=[0.3, 0.3, 0.5], radius=0.15)
    found = draw(scene, (floor, plate, scene.planes[2]), 150)
    place = sensor_frames(scene.robot, scene.sensor.T_flange_sensor, found.q)[:, :3, 3]
    beyond = place[place[:, 0] > 0.3]
    assert len(beyond) and np.all(place[:, 2] > 0)
    assert np.all(np.linalg.norm(beyond[:, 1:] - [0.3, 0.5], axis=1) > 0.15)
    endless = draw(scene, (floor, replace(plate, centre=None, radius=None), scene.planes[2]), 150)
    place = sensor_frames(scene.robot, scene.sensor.T_flange_sensor, endless.q)[:, :3, 3]
    assert np.all(place[:, 0] < 0.3)


def test_an_extent_is_written_and_read(tmp_path, scene):
    """The circle of a plane survives the mapping of dataset.yaml; a plane without one has no such key."""
    plane = PlaneGuess("floor", [0, 0, 2.0], 0.4, centre=[0.5, 0.1, 0.2], radius=0.25)
    again = PlaneGuess.from_mapping(plane.to_mapping())
    assert again.centre.tolist() == [0.5, 0.1, 0.2] and again.radius == 0.25
    assert again.normal.tolist() == [0.0, 0.0, 1.0] and again.distance == 0.2
    assert "extent" not in scene.planes[0].to_mapping()


@pytest.mark.parametrize(
    ("centre", "faults"), [([0.9, 3.0, -2.0], 0), ([0.75, 0.0, 0.0], 0), ([900.0, 0.1, 0.6], 1)]
)
def test_a_centre_off_its_plane_is_refused(scene, centre, faults):
    """The middle of a plate may lie anywhere on its plane, as exactly as planes are guessed; millimetres for metres do not."""
    plane = PlaneGuess("wall", [1, 0, 0], 0.9, centre=centre, radius=0.2)
    given = Description(description("cell", "", scene.robot, scene.sensor, [*scene.planes, plane]), {})
    check_description(given)
    assert [fault.column for fault in given.faults] == faults * [f"planes[{len(scene.planes)}].extent.centre"]
