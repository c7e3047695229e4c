"""A tracker or a probe takes too few readings at a pose to show its own noise: the residual shows whether a statement is too large."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.sensors import measure
from scalar.sensors.probe import Probe
from scalar.sensors.residual_noise import factor_within_poses, noise_factor, rows_within_poses, scaled_up
from tests.random_scene import make_scene
from tests.tracked_targets import drawn_arm

TRUE = 1e-4  # m


@pytest.mark.parametrize(
    ("rms", "rows", "unknowns", "stated", "kept"),
    [
        (0.5, 600, 36, True, False),  # clearly smaller than stated
        (0.9, 6000, 36, True, True),  # beyond chance, but no more than instruments of one kind differ
        (0.7, 60, 36, True, True),  # 24 degrees of freedom: may be by chance
        (3.0, 600, 36, True, True),  # the model may lack an effect
        (3.0, 600, 36, False, False),
        (0.5, 600, 36, False, False),
        (0.1, 50, 36, False, True),  # the fit has adapted to nearly all rows
    ],
)
def test_a_stated_noise_is_kept_unless_the_residual_is_clearly_smaller(rms, rows, unknowns, stated, kept):
    """A stated noise is kept unless the residual is clearly smaller; without one, the residual decides as soon as it has degrees of freedom."""
    assert noise_factor(rms, rows, unknowns, stated=stated) == (1.0 if kept else rms)


def test_a_residual_is_scaled_up_for_the_parameters():
    """If 36 of 100 rows are spent on parameters, the mean square is multiplied by 100 / 64, and never by more than two."""
    assert scaled_up(1.0, 100, 36) == pytest.approx(1.25)
    assert scaled_up(1.0, 100, 90) == pytest.approx(np.sqrt(2.0))


@pytest.mark.parametrize("stated", [None, 1e-3, 1e-4, 1e-5])
def test_a_tracker_with_the_wrong_statement(stated):
    """If the stated noise is too large or missing, it is estimated to a few per cent; if it is right or too small, it is kept."""
    rng = np.random.default_rng(5)
    arm = drawn_arm(rng, ("ball",))
    dataset = arm.dataset(arm.poses(200, rng), rng, stated={"noise": stated})
    measured = measure(dataset)
    T = dataset.robot.flange(dataset.q) @ dataset.sensor.T_flange_sensor
    target = measured.fitted_target(T, measured.initial_target(dataset))
    # Measurements of the nominal arm: the model leaves the noise alone.
    left = (measured.rows(T, target).residual * measured.sigma).reshape(measured.positions.shape)
    exact = replace(measured, positions=measured.positions + left + TRUE * rng.normal(size=left.shape))
    found = exact.reweighted(T, target)
    kept = stated in (1e-4, 1e-5)
    assert found.sigma_stated == kept
    assert found.sigma == (stated if kept else pytest.approx(TRUE, rel=0.15))
    assert found.ratio_to_stated == (None if stated is None else pytest.approx(found.sigma / stated))
    assert [noise.name for noise in found.estimated_noise] == ([] if kept else ["position_noise"])
    again = exact.weighted_like(found)
    assert again.sigma == again.reweighted(T, target).sigma == found.sigma


@pytest.mark.parametrize("stated", [None, 1.0, 1e-4])
def test_a_probe_with_the_wrong_statement(stated):
    """If a probe's stated noise is too large or missing, it is estimated as the residual of the nominal arm, scaled up for the parameters."""
    dataset = make_scene(kind="probe", poses_per_plane=60, seed=2).dataset
    probe = Probe.of(replace(dataset, sensor=replace(dataset.sensor, noise=stated)))
    T, target = (
        dataset.robot.flange(dataset.q) @ dataset.sensor.T_flange_sensor,
        probe.initial_target(dataset),
    )
    heights = probe.predicted(T, target, probe.target_index)[0]
    found = probe.reweighted(T, target)
    if stated == 1e-4:
        assert found is probe  # the residual of the nominal arm is larger, which proves nothing
        return
    rms = np.sqrt(np.mean(heights**2))
    assert not found.sigma_stated and rms < found.sigma < np.sqrt(2) * rms
    assert (
        1e-3 < found.sigma < 0.1
    )  # what a nominal arm leaves: far more than 0.1 mm, and far less than a metre
    assert [noise.name for noise in found.estimated_noise] == ["position_noise"]
    assert probe.weighted_like(found).reweighted(T, target).sigma == found.sigma


@pytest.mark.parametrize("names", [("a", "b"), ("a", "b", "c")])
def test_several_targets_show_their_noise_whatever_the_arm_does(names):
    """If each pose is moved by millimetres as a rigid body and a fifth has a gross error, the targets' scatter is found to 15 %."""
    rng = np.random.default_rng(11)
    arm = drawn_arm(rng, names)
    q = arm.poses(200, rng)
    q_true = q + rng.normal(0.0, 5e-3, q.shape)
    dataset = arm.dataset(q, rng, noise=TRUE, stated={"noise": 2e-5}, q_true=q_true)
    exact = arm.dataset(q, rng, stated={"noise": 2e-5})
    measured = measure(dataset)
    T = dataset.robot.flange(q) @ dataset.sensor.T_flange_sensor
    target = measure(exact).fitted_target(T, measured.initial_target(dataset))
    residual, moved = (getattr(measured.rows(T, target), key) for key in ("residual", "wrench"))
    # What the nominal geometry does to the places of the targets on the flange is no rigid motion; it is taken out with exact measurements.
    residual = residual - measure(exact).rows(T, target).residual
    residual[:40, 0] += 1e3
    measured = np.ones(residual.shape, dtype=bool)
    assert factor_within_poses(residual, moved, measured, stated=True) == pytest.approx(5.0, rel=0.15)


def test_the_noise_within_poses_is_neither_too_small_nor_more_exact_than_stated():
    """If some poses show two targets of three, (hat - true)/std has mean zero and at most unit spread; such poses had made it 6 % too small."""
    rng = np.random.default_rng(3)
    factors = []
    seen = np.ones((90, 3), dtype=bool)
    seen[::3, 2] = False
    for _ in range(300):
        arms = rng.normal(0.0, 0.05, (90, 3, 3))
        turns = -np.cross(arms[:, :, None, :], np.eye(3))
        moved = np.concatenate([np.broadcast_to(np.eye(3), (90, 3, 3, 3)), turns], axis=-1)
        rows = np.repeat(seen, 3, axis=1)
        residual = rng.normal(0.0, 1.0, (90, 9)) * rows
        factors.append(
            factor_within_poses(residual, moved.reshape(90, 9, 6) * rows[:, :, None], rows, stated=False)
        )
    std = 1.0 / np.sqrt(2.0 * rows_within_poses(seen))
    deviations = (np.array(factors, dtype=float) - 1.0) / std
    assert abs(deviations.mean()) < 0.15
    assert 0.7 < deviations.std() < 1.1


def test_one_target_shows_nothing_within_a_pose():
    """One target shows no noise within a pose, since its three coordinates move freely with the pose."""
    moved = np.tile(np.hstack([np.eye(3), np.eye(3)]), (50, 1, 1))
    assert factor_within_poses(np.ones((50, 3)), moved, np.ones((50, 3), dtype=bool), stated=True) is None


def test_a_stated_noise_needs_no_measurements():
    """A dataset without measurements, as `scalar plan` makes, is accepted, and nothing is said of its noise relative to the stated one."""
    rng = np.random.default_rng(5)
    arm = drawn_arm(rng, ("ball",))
    dataset = arm.dataset(arm.poses(3, rng), rng, stated={"noise": TRUE})
    unmeasured = replace(
        dataset, points=dataset.points[:0], starts=np.zeros_like(dataset.starts), point_columns={}, targets=()
    )
    assert measure(unmeasured).ratio_to_stated is None
