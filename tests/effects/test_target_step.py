"""A tracker that is knocked, or a base that moves at once: a step of the same effect as a slow drift."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.diagnosis import diagnose
from scalar.effects.target_drift import TargetDrift
from scalar.estimation.calibrate import calibrate
from scalar.export.rigid_part import rigid_part
from scalar.geometry.se3 import exp_so3
from scalar.report.advice import GEOMETRY, advice
from tests.cli.running import run
from tests.random_scene import make_scene


def knocked(first: int, shift: float, seed: int) -> Dataset:
    """Return a campaign whose tracker stands ``shift`` [m] away, and turned by a tenth of that in rad, from row ``first`` on."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=3e-5, seed=seed).dataset
    points = dataset.points.copy()
    points[first:] = points[first:] @ exp_so3([0.0, 0.1 * shift, -0.1 * shift]).T + [shift, 0.0, 0.5 * shift]
    return replace(
        dataset, points=points, poses=dataset.poses.assign(order=np.arange(float(dataset.n_poses)))
    )


@pytest.mark.parametrize(("first", "seed"), [(30, 7), pytest.param(52, 8, marks=pytest.mark.slow)])
def test_a_knocked_tracker_is_a_step_and_no_drift(first, seed):
    """The movement is named with the pose at which it happened and its size, and nothing else is; the advice is a session of its own."""
    diagnosis = diagnose(knocked(first, 3e-4, seed))
    (finding,) = diagnosis.findings
    effect = finding.effect
    assert isinstance(effect, TargetDrift) and effect.by == "step"
    assert effect.order == first  # without a column order, rows count from 0
    shift = float(np.linalg.norm(effect.coefficients[3:]))
    assert shift == pytest.approx(
        3e-4 * np.hypot(1.0, 0.5), rel=0.5
    )  # at the base, about which the turn is taken
    assert "column session" in effect.advice[0] and "warm up" not in effect.advice[0]
    assert "without it the rows count from 0" in effect.advice[0]  # a pose numbered 75 may have order 74
    (in_controller,) = [
        item for item in advice(diagnosis, diagnosis.to_mapping()) if item.about == "In the controller"
    ]
    assert in_controller.sentences[0] == f"{GEOMETRY}."  # no effect is left out there


def test_a_step_moves_no_later_pose_of_the_arm():
    """Poses that are no part of the campaign are predicted as without the step, and no exported geometry has it; within the campaign it acts."""
    dataset = knocked(30, 3e-4, 7)
    effect = TargetDrift("step", order=30.0)
    calibration = calibrate(dataset, effects=(effect,))
    (stepped,) = calibration.model.effects
    still = replace(calibration, model=replace(calibration.model, effects=()))
    np.testing.assert_array_equal(calibration.predict(dataset.q), still.predict(dataset.q))
    order = np.arange(dataset.n_poses)
    moved = calibration.predict(dataset.q, order=order) - still.predict(dataset.q, order=order)
    assert not moved[:30].any() and np.abs(moved[30:, :3, 3]).max() > 1e-4
    rigid = rigid_part(calibration.model, {})
    assert stepped.coefficients.any() and not rigid.included and not rigid.left_out
    np.testing.assert_array_equal(rigid.robot.T_base_0, calibration.model.robot.T_base_0)


def test_a_table_with_orders_is_told_that_the_step_is_in_its_frames(tmp_path):
    """``predict`` says that the frames of rows with an order contain the movement of the tracker, and nothing where no row has one."""
    dataset = knocked(30, 3e-4, 7)
    calibrate(dataset, effects=(TargetDrift("step", order=30.0),)).save(tmp_path / "calibration.json")
    names = [f"q{j + 1}" for j in range(6)]
    table = dataset.poses[["pose", *names]]
    for timed in (True, False):
        rows = table.assign(order=np.arange(len(table))) if timed else table
        rows.to_csv(tmp_path / "joints.csv", index=False)
        files = tmp_path / "calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "frames.csv"
        said = run("predict", *files, "--force").output
        assert ("movement of the tracker or the base" in said) is timed


def test_no_step_is_found_where_the_tracker_stands_still():
    """On noise alone nothing is named."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=3e-5, seed=9).dataset
    assert not diagnose(dataset).findings
