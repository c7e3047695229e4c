"""What few poses leave open of an effect that was found: it is asked for as a whole, and counted in the error that is stated."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
from scalar.diagnosis.result import Diagnosis
from scalar.effects.joint_compliance import JointCompliance
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.evaluate.pose_errors import aligned_to
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import exp_so3
from scalar.planning.after import After, poses_after
from scalar.planning.candidates import draw_candidates
from scalar.planning.left_open import left_open
from scalar.planning.questions import open_pairs
from scalar.planning.workcell import Workcell
from scalar.report.beyond_ranges import error_left_open
from scalar.robots import read_arm
from tests.kinematics import chain

SAG, NOISE = 4e-4, 3e-5
ROBOT = Robot.from_mapping(read_arm("denso_vs060").mapping)
T_SENSOR = np.eye(4)
T_SENSOR[0, 3] = T_SENSOR[2, 3] = 0.1


def stands(q: np.ndarray) -> np.ndarray:
    """Return where an arm stands whose joint 2 gives way under the weight of links 2 and 3, ``(N, 4, 4)``, by the tests' own kinematics."""
    bent = q.copy()
    bent[:, 1] += SAG * np.sin(q[:, 1]) + SAG * np.cos(q[:, 1] + q[:, 2])
    return chain(ROBOT.geometry, bent, ROBOT.T_base_0) @ ROBOT.T_n_flange @ T_SENSOR


@dataclass(frozen=True, eq=False)
class Case:
    """A tracked arm, its calibration with the torque of link 2 alone, and what a diagnosis would say of it."""

    dataset: Dataset
    calibration: Calibration
    diagnosis: dict[str, Any]

    @property
    def error(self) -> float:
        """Return the true error of predicted positions within the joint limits [m]."""
        q = np.random.default_rng(7).uniform(*ROBOT.limits.T, (400, 6))
        found = aligned_to(stands(q), self.calibration.predict(q))
        return float(np.sqrt(np.mean(np.sum((found - stands(q))[:, :3, 3] ** 2, axis=1))))

    def after(self) -> After:
        """Return what twenty further poses tell."""
        cell = Workcell.of(
            ROBOT, self.dataset.sensor, (), self.calibration, repeatability=2e-5, same_campaign=True
        )
        found = draw_candidates(cell, 200, np.random.default_rng(0))
        left = open_pairs(self.diagnosis, self.calibration.model.effects, self.dataset)
        return poses_after(cell, found, self.dataset, self.calibration, left)


def case(width: float, noise: float = NOISE, links: tuple[int, ...] = (2,)) -> Case:
    """Return the case whose joint 3 was measured over a width [rad], and all other joints over their whole range.

    Args:
        width: Of joint 3.
        noise: Of the tracker [m].
        links: Whose torques the calibration has.
    """
    rng = np.random.default_rng(5)
    q = rng.uniform(*ROBOT.limits.T, (60, 6))
    q[:, 2] = 1.0 + rng.uniform(-width / 2, width / 2, 60)
    points = stands(q)[:, :3, 3] + noise * rng.standard_normal((60, 3))
    dataset = Dataset.from_arrays(robot=ROBOT, sensor=Sensor("tracker", T_SENSOR, noise), q=q, points=points)
    effect = JointCompliance(tuple((2, link) for link in links))
    made = calibrate(dataset, effects=(effect,))
    (found,) = made.model.effects
    entry = {
        "name": found.name,
        "target": found.target,
        "coefficients": {
            name: {"value": value}
            for name, value in zip(found.coefficient_names, found.coefficients, strict=True)
        },
        "confounded_with": [{"name": "joint_harmonic", "target": {"joint": 2, "order": 1}}],
    }
    return Case(dataset, made, {"effects": [entry], "unobservable": []})


@pytest.fixture(scope="module")
def narrow() -> Case:
    """Return the case whose joint 3 hardly moved."""
    return case(0.1)


def test_a_sag_by_one_link_is_asked_for_by_all_links(narrow: Case) -> None:
    """By the torque of link 2 alone a sag is a sine of joint 2, as a gear's error is.

    Links beyond weigh something too, and poses are planned that show it.
    """
    (pair,), _ = open_pairs(narrow.diagnosis, narrow.calibration.model.effects, narrow.dataset)
    assert {term[1] for term in pair.effect.terms} == set(range(2, 7))  # type: ignore[attr-defined]
    (answer,) = narrow.after().answers
    assert answer.now < 25 < answer.limit
    found = narrow.calibration.model.effects[0].coefficients
    assert np.linalg.norm(answer.question.size[2:]) > 0.1 * np.linalg.norm(found)


def test_the_stated_error_counts_what_is_left_open(narrow: Case) -> None:
    """The error that is stated is of the size of the true one, which is many times that of the parameters that were fitted."""
    found = left_open(narrow.dataset, narrow.calibration, narrow.diagnosis)
    assert found is not None
    assert 0.5 * narrow.error < found.error < 3.0 * narrow.error
    assert narrow.error > 3.0 * NOISE


def test_the_noise_of_a_tracker_need_not_be_stated(narrow: Case) -> None:
    """The residual at the fitted place of the tracker shows it, so both the stated error and the signal of further poses are those of a stated
    noise; at the unknown place of the tracker the residual would be metres."""
    points = narrow.dataset.points @ exp_so3([0.1, -0.2, 2.0]).T + [2.5, -1.2, 0.3]
    sensor = replace(narrow.dataset.sensor, noise=None)
    unstated = replace(narrow, dataset=replace(narrow.dataset, sensor=sensor, points=points))
    stated, found = (left_open(c.dataset, c.calibration, c.diagnosis) for c in (narrow, unstated))
    assert stated is not None and found is not None
    assert found.error == pytest.approx(stated.error, rel=0.3)
    (before,), (after,) = narrow.after().answers, unstated.after().answers
    assert after.now == pytest.approx(before.now, rel=0.7, abs=1.0)


@dataclass(frozen=True, eq=False)
class Diagnosed:
    """What the report reads of a diagnosis."""

    dataset: Dataset
    calibration_after: Calibration
    findings: tuple[str, ...]
    content: dict[str, Any]

    def to_mapping(self) -> dict[str, Any]:
        """Return the content of ``diagnosis.json``."""
        return self.content


def test_the_report_takes_the_scatter_that_the_poses_show() -> None:
    """Poses that scatter by the sensor's noise alone show how well the arm repeats them: the stated error adds no usual repeatability."""
    precise = case(4.0, 2e-6, (2, 3))
    diagnosis = Diagnosed(precise.dataset, precise.calibration, ("sag",), precise.diagnosis)
    found = error_left_open(cast(Diagnosis, diagnosis))
    assert found is not None
    assert precise.error / 2 < found.error < 3.0 * precise.error
