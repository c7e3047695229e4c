"""A wrong sign or zero that leaves no residual is named where another number takes its error up, and not that number."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup import explain as search
from scalar.estimation.setup.alternatives import Alternative, with_robot, with_sign_changed
from scalar.estimation.setup.trial import NominalFit
from scalar.geometry.robot import GEOMETRY
from scalar.units import DEG, MM
from tests.random_scene import make_scene


def measured(q, T_flange_target, like: Dataset) -> Dataset:
    """Return what a tracker measures of the nominal arm of a dataset at other joint angles ``(N, n)`` [rad], with the stated noise of 0.1 mm."""
    points = (like.robot.flange(q) @ T_flange_target)[:, :3, 3]
    points = points + np.random.default_rng(3).normal(0.0, 0.1 * MM, points.shape)
    poses = like.poses.assign(**{f"q{j + 1}": q[:, j] for j in range(q.shape[1])})
    return replace(
        like, poses=poses, points=points, sensor=replace(like.sensor, T_flange_sensor=T_flange_target)
    )


def turned(dataset: Dataset, joint: int, degrees: float) -> Dataset:
    """Return the dataset whose angles of one joint (from 1) count from another zero."""
    name = f"q{joint}"
    return replace(dataset, poses=dataset.poses.assign(**{name: dataset.poses[name] + degrees * DEG}))


@pytest.fixture(scope="module")
def like() -> Dataset:
    """Return seventy-five poses before a tracker, of an arm with a spherical wrist."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset


@pytest.fixture(scope="module")
def on_the_last_axis(like) -> Dataset:
    """Return a target that lies on the last axis, so that the zero of the last but one joint can be taken up by a length."""
    T = np.eye(4)
    T[2, 3] = 0.1
    return measured(like.q, T, like)


def test_a_zero_that_a_length_takes_up_is_named(on_the_last_axis):
    """The zero of joint 5 is off by a quarter turn: a_6 comes out centimetres off, and the zero is named in its place."""
    (told,) = calibrate(turned(on_the_last_axis, 5, 90.0)).summary["setup"]
    assert (told["what"], told["where"]) == ("joint_reading", "joint 5")
    assert (
        "a_6 comes out" in told["sentence"]
        and "the zero of joint 5 is off by -90 degrees" in told["sentence"]
    )
    assert not calibrate(on_the_last_axis).summary["setup"]


def test_a_length_that_is_wrong_is_still_a_length(on_the_last_axis):
    """Where no sign and no zero explains a link that comes out 50 mm off, the table of joints is asked about it."""
    geometry = on_the_last_axis.robot.geometry.copy()
    geometry[GEOMETRY.index("a"), 2] += 50 * MM
    robot = on_the_last_axis.robot.with_geometry(geometry)
    told = calibrate(replace(on_the_last_axis, robot=robot)).summary["setup"]
    assert [(s["what"], s["where"]) for s in told] == [("robot", "a_3")]


def test_of_readings_that_turn_nothing_those_that_explain_most_are_fitted(monkeypatch):
    """A tracker that measures no orientations shows no turn. The few readings that are fitted in full are then those with the smallest residuals,
    not the first ones of the list, in which signs stand before zeros.
    """
    residuals = [1.5, 1.6, 1.4, 1.7, 0.3, 1.8]  # [mm], of readings in the order of the list; 2.5 as described
    fitted: list[int] = []
    monkeypatch.setattr(search, "nominal_fit", lambda index: NominalFit(residuals[index] * MM, 0.0, 0.1))
    monkeypatch.setattr(search, "full_fit", fitted.append)
    tried: Any = [Alternative("", "", "", "", "", cast("Any", index)) for index in range(len(residuals))]
    search._explaining(tried, NominalFit(2.5 * MM, 0.0, 0.1), None)
    assert fitted[0] == 4 and len(fitted) < len(residuals)


def test_readings_that_say_the_same_stay_in_the_order_of_the_list(monkeypatch):
    """A wrong sign of joint 1 and a zero of joint 2 that is half a turn off leave almost the same residual; the sign is first."""
    residuals = [0.301, 0.30, 0.302]  # [mm]
    fitted: list[int] = []
    monkeypatch.setattr(search, "nominal_fit", lambda index: NominalFit(residuals[index] * MM, 0.0, 0.1))
    monkeypatch.setattr(search, "full_fit", fitted.append)
    tried: Any = [Alternative("", "", "", "", "", cast("Any", index)) for index in range(len(residuals))]
    search._explaining(tried, NominalFit(2.5 * MM, 0.0, 0.1), None)
    assert fitted == [0, 1, 2]


@pytest.mark.parametrize(("by", "is_said"), [(0.4, True), (0.002, False)])
def test_a_reading_under_which_a_link_is_far_off_is_doubted(like, by, is_said):
    """Three signs may fit the table of another arm, if its links may change: the length is said, and no corrected table is offered."""
    robot = with_sign_changed(like.robot, 3)
    geometry = robot.geometry.copy()
    geometry[GEOMETRY.index("a"), 2] += by
    trial: Any = SimpleNamespace(rms=0.1 * MM, model=SimpleNamespace(robot=robot.with_geometry(geometry)))
    reading = with_robot(
        like, robot, "joint_sign", "joint 4", "joint 4 counts the other way", "with its sign changed"
    )
    said = search._suspicion(reading, 60 * MM, trial, one_of=1)
    assert ("a_3 comes out 400 mm from the table of joints even then" in said.sentence) == is_said
    assert (said.robot is None) == is_said


@pytest.mark.parametrize(("robot", "kind"), [("vs060", "line-laser"), ("ur10e", "tracker")])
def test_signs_of_all_joints_that_a_mirror_image_hides_are_named(robot, kind):
    """With all signs wrong an arm fits as its own mirror image; on planes a zero of joint 6 explains less, as it leaves a wall on the other side."""
    sound = make_scene(robot, kind, poses_per_plane=25, noise=1e-4, seed=7).dataset
    spoilt = replace(sound, poses=sound.poses.assign(**{f"q{j}": -sound.q[:, j - 1] for j in range(1, 7)}))
    told = {entry["what"]: entry for entry in calibrate(spoilt).summary["setup"]}
    assert told["joint_reading"]["where"] == "all joints"
    assert "if all joints count the other way" in told["joint_reading"]["sentence"]
    assert "joint 6" not in told["joint_reading"]["sentence"]
