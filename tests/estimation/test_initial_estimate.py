"""Where the fit starts: the linear guess is exact where its premises hold, and good enough where they
do not.
"""

from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.prepare import prepare
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.geometry.planes import Planes
from scalar.sensors import measure
from scalar.sensors.linear_guess import linear_guess
from scalar.units import DEG, MM
from tests import kinematics
from tests.estimation.test_data_sheet_priors import workcell
from tests.random_scene import make_scene
from tests.workcell import PLANE_NAMES

CELLS = 30


def test_the_linear_guess_is_exact_for_a_true_arm_and_known_planes():
    """As in section III-A, with the true arm, the true floor and no noise, nine linear unknowns give the scanner's pose."""
    scene = make_scene(noise=0.0, stated_noise=1e-4)
    truth, data = scene.truth, scene.dataset
    T_base_flange = truth.sensor(data.q) @ np.linalg.inv(truth.T_flange_sensor)
    planes = Planes.at(PLANE_NAMES, truth.normals, truth.distances)
    for use in (data.plane_index == 0, np.ones(data.n_poses, dtype=bool)):
        found = linear_guess(measure(data), T_base_flange, planes, use)
        np.testing.assert_allclose(found, truth.T_flange_sensor, atol=1e-10)


def test_the_linear_guess_is_a_rotation_whatever_the_data():
    """With a wrong arm and wrong planes the guess is rough, but a rigid transform."""
    scene = make_scene(plane_tilt=20 * DEG, plane_offset=50 * MM, angle_error=3 * DEG)
    data = scene.dataset
    measurement = measure(data)
    use = np.ones(data.n_poses, dtype=bool)
    T = linear_guess(measurement, data.robot.flange(data.q), measurement.initial_target(data), use)
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)


@pytest.mark.parametrize("robot", ["vs060", "ur10e"])
def test_no_nominal_pose_and_a_floor_that_is_30_degrees_off(robot):
    """In 30 workcells of 30 the scanner is found within the arm's own error, and the calibration reaches the optimum of the truth."""
    for seed in range(CELLS):
        scene = make_scene(
            robot,
            seed=100 + seed,
            plane_tilt=30 * DEG,
            plane_offset=100 * MM,
            nominal_pose=False,
            points_per_scan=30,
        )
        prepared = prepare(scene.dataset)
        assert prepared.initial.origin == "linear guess"
        T = np.linalg.inv(scene.truth.T_flange_sensor) @ prepared.initial.model.T_flange_sensor
        assert np.linalg.norm(T[:3, 3]) < 100 * MM, seed
        assert np.linalg.norm(kinematics.rotation_vector(T[:3, :3])) < 10 * DEG, seed
        if seed < 5:
            found = calibrate(scene.dataset).model.robot.geometry
            assert np.abs(found - scene.truth.geometry).max() < 2e-3


def test_a_wrong_nominal_pose_does_no_harm():
    """If the stated pose is 200 mm and 90 degrees off, it is tried, and the linear guess is taken instead."""
    for seed in range(5):
        scene = make_scene(seed=seed, pose_offset=(0.2, 90 * DEG), points_per_scan=30)
        found = calibrate(scene.dataset)
        assert np.abs(found.model.robot.geometry - scene.truth.geometry).max() < 2e-3


def test_a_good_nominal_pose_serves_where_the_linear_guess_cannot():
    """With few poses and a stated pose, the fit starts from the stated pose."""
    scene = make_scene(poses_per_plane=8, pose_offset=(2 * MM, 1 * DEG))
    assert prepare(scene.dataset).initial.rms < 30 * MM


def test_poses_that_do_not_turn_the_scanner_are_refused():
    """Without a nominal pose and with one pose repeated, the nine numbers are not determined, and the message says what would help."""
    scene = make_scene(nominal_pose=False, points_per_scan=10)
    data = scene.dataset
    first = {k: int(np.flatnonzero(data.plane_index == k)[0]) for k in range(3)}
    same = data.subset(np.sort(np.repeat(list(first.values()), 14)))
    with pytest.raises(Undetermined, match=r"of the 9 numbers.*sensor\.nominal_pose"):
        calibrate(same)


def test_a_probe_needs_its_nominal_pose():
    """A probe has no linear guess, so the message asks for its nominal pose."""
    scene = make_scene(kind="probe")
    data = replace(scene.dataset, sensor=replace(scene.dataset.sensor, T_flange_sensor=None))
    with pytest.raises(Undetermined, match=r"sensor\.nominal_pose"):
        calibrate(data)


@pytest.mark.parametrize("robot", ["vs060", "ur10e"])
@pytest.mark.parametrize("times", [5, pytest.param(10, marks=pytest.mark.slow)])
def test_an_arm_that_is_ten_times_as_wrong_is_calibrated(robot, times):
    """With errors of 20 mm and 10 degrees and no noise, at least nine workcells of ten end with no residual, and the others are refused.

    Some axes start far from parallel and end parallel. The true arms are those of the library, so a refusal may name the arm that was measured.
    """
    refused = 0
    for seed in range(10):
        scene = make_scene(
            robot,
            seed=300 + seed,
            points_per_scan=20,
            noise=0.0,
            stated_noise=1e-4,
            length_error=times * 2 * MM,
            angle_error=times * 1 * DEG,
        )
        try:
            found = calibrate(scene.dataset)
        except (Undetermined, WrongSetup):
            refused += 1
            continue
        assert found.residual_rms < 1e-12, seed
    assert refused <= 1


def pointing_up(seed, gear=0.0):
    """Return a tracked arm whose flange's axis is upright at all 60 poses but for a milliradian; ``gear`` as in ``workcell``."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.0, 1.0, (60, 6)) * np.array([2.5, 0.8, 0.8, 0.0, 0.0, 2.5])
    robot = workcell(seed, q)[0].robot

    def leaning(wrist: np.ndarray) -> np.ndarray:
        """Return how far the flange's axis leans out of the vertical at each pose [rad], with the angles ``(60,)`` of joint 5."""
        q[:, 4] = wrist
        z = robot.flange(q)[:, :3, 2]
        return np.arctan2(np.hypot(z[:, 0], z[:, 1]), z[:, 2])

    tries = np.linspace(-np.pi, np.pi, 721)
    best = tries[np.argmin([leaning(np.full(60, each)) for each in tries], axis=0)]
    for width in 0.01 * 0.5 ** np.arange(16):
        steps = best + width * np.array([[-1.0], [0.0], [1.0]])
        nearest = np.argmin([leaning(each) for each in steps], axis=0)
        best = np.take_along_axis(steps, nearest[None], axis=0)[0]
    assert leaning(best).max() < 1e-3
    return workcell(seed, q, gear=gear)[0]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_tool_that_always_points_up_keeps_its_stated_length(seed):
    """Errors of the arm had moved the reflector far along the flange's axis."""
    dataset = pointing_up(seed)
    stated = dataset.sensor.T_flange_sensor[:3, 3]
    found = prepare(dataset).initial.model.T_flange_sensor[:3, 3]
    assert np.linalg.norm(found - stated) < 50 * MM
