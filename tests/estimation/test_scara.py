"""A place of the sensor on the flange that is not fitted stays as it was stated: along the parallel axes of a SCARA, and where it is held."""

import numpy as np
import pytest

from scalar import calibrate
from scalar.comparison import compare
from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
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
