"""A place that is not fitted stays as it was stated: the sensor's along the parallel axes of a SCARA, the sensor's or a plane's where it is held."""

import numpy as np
import pytest

from scalar import calibrate
from scalar.comparison import compare
from scalar.data.dataset import Dataset
from scalar.data.declared import PlaneGuess, Sensor
from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.geometry.robot import Robot
from tests.kinematics import rotate_about, rotation, translation
from tests.rail_and_arm import off_by_a_motion
from tests.random_scene import make_scene

STATED = np.array([0.06, 0.0, 0.03])  # m, the sensor on the flange
TRUE = np.array([0.0606, -0.0004, 0.0309])
LINKS = [
    (0.40, 0.0, 0.30),
    (0.35, np.pi, 0.0),
    (0.0, 0.0, 0.0),
    (0.0, 0.0, 0.05),
]  # a [m], alpha [rad], d [m]
LIMITS = np.array([[-2.2, 2.2], [-2.4, 2.4], [0.02, 0.30], [-2.9, 2.9]])  # rad; m of joint 3, which slides
TILTS = np.array([[0, 6e-4], [-5e-4, 9e-4], [7e-4, -6e-4], [0, 0]])  # rad, of the next axis about x and y
NOISE = 2e-5  # m


def nominal() -> Robot:
    """Return the arm of the data sheet."""
    joints = [
        {"a": a, "alpha": alpha, "d": d, "theta": 0.0, "limits": limits.tolist()}
        for (a, alpha, d), limits in zip(LINKS, LIMITS, strict=True)
    ]
    joints[2]["type"] = "prismatic"
    return Robot.from_mapping({"name": "scara", "convention": "standard-dh", "joints": joints})


def places(q: np.ndarray, longer: float = 0.0) -> np.ndarray:
    """Return where the sensor really is ``(N, 3)`` [m], by elementary motions; its axes are tilted, and link 1 is ``longer`` [m]."""
    found = []
    for row in q:
        T = np.eye(4)
        for j, (a, alpha, d) in enumerate(LINKS):
            motion = translation(2, row[j]) if j == 2 else rotation(2, row[j])
            T = T @ motion @ translation(2, d) @ translation(0, a + longer * (j == 0)) @ rotation(0, alpha)
            T = T @ rotation(0, TILTS[j, 0]) @ rotation(1, TILTS[j, 1])
        found.append(T[:3] @ np.r_[TRUE, 1.0])
    return np.array(found)


def tracked(seed: int, longer: float = 0.0, count: int = 100) -> Dataset:
    """Return what a tracker measures that stands somewhere in the hall."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(*LIMITS.T, (count, 4))
    R = rotate_about(rng.normal(size=3), rng.uniform(0.3, 2.5))
    points = places(q, longer) @ R.T + rng.uniform(-3, 3, 3) + NOISE * rng.normal(size=(count, 3))
    guess = np.eye(4)
    guess[:3, 3] = STATED
    sensor = Sensor("tracker", guess, noise=NOISE)
    return Dataset.from_arrays(robot=nominal(), sensor=sensor, q=q, points=points)


PLATES = [
    ("floor", [0.01, -0.02, 1.0], 0.10),
    ("left", [0.80, 0.60, 0.05], 0.45),
    ("right", [0.75, -0.62, -0.04], 0.42),
]  # normal, distance [m]


def touched(seed: int, count: int = 90) -> Dataset:
    """Return what a probe touches on three plates: joint 3 goes down to the floor, joint 2 turns to the walls."""
    rng = np.random.default_rng(seed)
    q, plates = [], []
    while len(q) < count:
        name, normal, distance = PLATES[len(q) % 3]
        at, moves = rng.uniform(*LIMITS.T), 2 if name == "floor" else 1
        n, contact = np.array(normal) / np.linalg.norm(normal), distance + NOISE * rng.normal()
        tried = np.tile(at, (30, 1))
        tried[:, moves] = np.linspace(*LIMITS[moves], 30)
        heights = places(tried) @ n - contact
        crossing = np.flatnonzero(heights[:-1] * heights[1:] < 0)
        if len(crossing):
            ends = tried[crossing[0] : crossing[0] + 2]
            for _ in range(40):
                middle = ends.mean(axis=0)
                ends[
                    int((places(middle[None])[0] @ n - contact) * (places(ends[1:])[0] @ n - contact) > 0)
                ] = middle
            q.append(ends[0])
            plates.append(name)
    guesses = [PlaneGuess(name, np.array(n) / np.linalg.norm(n), d + 2e-3) for name, n, d in PLATES]
    guess = np.eye(4)
    guess[:3, 3] = STATED
    sensor = Sensor("probe", guess, noise=NOISE)
    return Dataset.from_arrays(robot=nominal(), sensor=sensor, q=np.array(q), plane=plates, planes=guesses)


def tilted() -> list[AxisNonparallel]:
    """Return the tilts about y that Denavit and Hartenberg's parameters lack."""
    return [AxisNonparallel(joint) for joint in (2, 3, 4)]


@pytest.fixture(scope="module")
def first():
    """Return the calibration of a campaign."""
    return calibrate(tracked(1), effects=tilted())


def test_a_place_along_parallel_axes_stays_as_it_was_stated(first):
    """The tracker could stand higher by as much as the sensor sits lower: the sensor keeps its stated height, and nothing is suspected."""
    np.testing.assert_allclose(first.model.T_flange_sensor[:3, 3], TRUE, atol=2e-3)
    assert first.model.T_flange_sensor[2, 3] == pytest.approx(STATED[2], abs=1e-12)
    assert "sensor_z" in first.fixed and not first.summary["setup"]
    q = np.random.default_rng(9).uniform(*LIMITS.T, (200, 4))
    assert off_by_a_motion(first.predict(q)[:, :3, 3], places(q)).max() < 3 * NOISE
    assert np.abs(first.predict(q)[:, 2, 3] - places(q)[:, 2]).max() < 5e-3  # the base is the nominal one


def test_a_probe_calibrates_a_scara():
    """The plates could sit lower together with the tip: the tip keeps its stated height, nothing is suspected, and unseen poses are right."""
    found = calibrate(touched(4), effects=tilted())
    assert found.model.T_flange_sensor[2, 3] == pytest.approx(STATED[2], abs=1e-12)
    assert not found.summary["setup"]
    q = np.random.default_rng(9).uniform(*LIMITS.T, (200, 4))
    off = off_by_a_motion(found.predict(q)[:, :3, 3], places(q))
    assert off.max() < 10 * NOISE


def test_two_campaigns_of_an_unchanged_arm_agree(first):
    """The tracker has moved and the noise is another one: no change is named, and a link that grew by 0.2 mm is."""
    again, grown = (calibrate(tracked(seed, by), effects=tilted()) for seed, by in ((2, 0.0), (3, 2e-4)))
    assert not compare(first, again).changes
    change = compare(first, grown).changes
    assert [one.candidate.name for one in change] == ["a_2"]
    assert change[0].value[0] == pytest.approx(2e-4, abs=5e-5)


@pytest.mark.parametrize("kind", ["tracker", "line-laser"])
def test_a_held_place_is_the_stated_one(kind):
    """A coordinate of the sensor's place that is held has exactly its stated value, however far from the fitted one it is."""
    dataset = make_scene(kind=kind, pose_offset=(2e-3, 0.0), points_per_scan=30).dataset
    T = dataset.sensor.T_flange_sensor
    held = calibrate(dataset, fix=["sensor_x"], explain=False)
    assert "sensor_x" not in held.free
    assert held.model.T_flange_sensor[0, 3] == pytest.approx(T[0, 3], abs=1e-12)
    assert abs(calibrate(dataset).model.T_flange_sensor[0, 3] - T[0, 3]) > 1e-4


@pytest.mark.parametrize("kind", ["probe", "line-laser"])
def test_a_held_plane_is_where_the_dataset_puts_it(kind):
    """Distance and normal of a plane that are held stay at its initial guess, and other planes are fitted to the data."""
    dataset = make_scene(kind=kind, points_per_scan=30).dataset
    name = dataset.planes[0].name
    names = [f"normal_{name}_u", f"normal_{name}_v", f"distance_{name}"]
    guess = np.r_[dataset.planes[0].normal, dataset.planes[0].distance]
    guess /= np.linalg.norm(guess[:3])
    apart = []
    for held in (names, []):
        planes = calibrate(dataset, fix=held, explain=False).model.target
        apart.append(np.c_[planes.normals, planes.distances] - guess)
    assert np.abs(apart[0][0]).max() < 1e-12 < 1e-5 < np.abs(apart[1][0]).max()


def test_one_held_coordinate_leaves_the_others_free():
    """A distance that is held keeps its value while the plane tilts."""
    dataset = make_scene(points_per_scan=30).dataset
    plane = dataset.planes[0]
    found = calibrate(dataset, fix=[f"distance_{plane.name}"], explain=False).model.target
    assert found.distances[0] == pytest.approx(plane.distance / np.linalg.norm(plane.normal), abs=1e-12)
    assert np.abs(np.cross(found.normals[0], plane.normal)).max() > 1e-6
