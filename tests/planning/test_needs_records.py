"""Effects that need what is recorded with a pose, such as torques, cannot be predicted at poses that are only planned."""

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from scalar.effects.torque_compliance import TorqueCompliance
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.geometry.robot import Robot
from scalar.planning.questions import open_pairs
from scalar.planning.workcell import Workcell
from scalar.robots import read_arm

ROBOT = Robot.from_mapping(read_arm("denso_vs060").mapping)
SENSOR = Sensor("tracker", np.eye(4), 5e-5)
GIVES_WAY = TorqueCompliance((2,))


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    """Return 40 tracked poses with recorded torques."""
    rng = np.random.default_rng(3)
    q = rng.uniform(*ROBOT.limits.T, (40, 6))
    torques = {f"tau{j + 1}": rng.normal(0.0, 20.0, 40) for j in range(6)}
    points = ROBOT.flange(q)[:, :3, 3]
    return Dataset.from_arrays(robot=ROBOT, sensor=SENSOR, q=q, points=points, columns=torques)


@pytest.fixture(scope="module")
def calibration(dataset: Dataset) -> Calibration:
    """Return a calibration with a compliance by measured torque."""
    return calibrate(dataset, effects=(GIVES_WAY,))


def test_poses_are_planned_near_a_calibration_that_needs_torques(calibration: Calibration) -> None:
    """The effect is left out, and the planned poses have their measurements; before, planning ended with a missing column."""
    cell = Workcell.of(ROBOT, SENSOR, (), calibration, same_campaign=True)
    assert calibration.model.effects and not cell.model.effects
    assert cell.dataset(np.zeros((3, 6)), np.full(3, -1)).n_poses == 3


def test_planned_poses_do_not_separate_an_effect_that_needs_torques(
    dataset: Dataset, calibration: Calibration
) -> None:
    """Such a question is listed among those that no poses answer, because the torques there are not known."""
    rival = {"name": "torque_compliance", "target": GIVES_WAY.target}
    entry = {"name": "joint_harmonic", "target": {"joint": 2, "order": 1}, "coefficients": {}}
    diagnosis = {"effects": [entry | {"confounded_with": [rival]}], "unobservable": []}
    pairs, not_by_poses = open_pairs(diagnosis, calibration.model.effects, dataset)
    assert pairs == [] and len(not_by_poses) == 1


@pytest.mark.parametrize(("name", "needs"), [("q3", False), ("order", False), ("oil_pressure", True)])
def test_a_term_needs_records_if_it_varies_with_a_recorded_column(name: str, needs: bool) -> None:
    """Joint angles and the order of acquisition are known when poses are planned; any other column is not."""
    assert UnattributedJoint(2, (Variable(name, 0.0, 1.0),)).needs_records is needs
