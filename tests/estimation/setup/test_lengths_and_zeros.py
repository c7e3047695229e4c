"""A length with the wrong sign, and two zeros that are wrong together, are named with the number that the table of joints should have."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.alternatives import read_as_standard
from scalar.estimation.setup.arm.lengths import _what_to_look_at
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.estimation.setup.tables.mistyped_numbers import length_signs
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.standard_dh import stated_mapping
from scalar.robots import read_arm
from scalar.units import DEG, MM
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def tracked() -> Dataset:
    """Return seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset


def with_length_negated(dataset: Dataset, kind: str, joint: int) -> Dataset:
    """Return the dataset with a length of a joint (from 1) negated in its table of joints."""
    geometry = dataset.robot.geometry.copy()
    geometry[GEOMETRY.index(kind), joint - 1] *= -1
    return replace(dataset, robot=dataset.robot.with_geometry(geometry))


@pytest.mark.parametrize(
    ("sensor", "kind", "joint"),
    [
        ("tracker", "a", 3),
        *(pytest.param(*c, marks=pytest.mark.slow) for c in (("tracker", "d", 4), ("line-laser", "d", 4))),
    ],
)
def test_a_length_with_the_wrong_sign_is_named(sensor, kind, joint):
    """It is named, and the corrected table is the one without the error."""
    sound = make_scene("vs060", sensor, poses_per_plane=25, points_per_scan=12, noise=1e-4, seed=7).dataset
    with pytest.raises(WrongSetup) as refused:
        calibrate(with_length_negated(sound, kind, joint))
    named = {suspicion.where: suspicion for suspicion in refused.value.suspicions}
    suspicion = named[f"{kind}_{joint}"]
    assert suspicion.what == "length_sign" and "the residual falls from" in suspicion.sentence
    assert suspicion.rms_after is not None and suspicion.rms_after < 0.5 * MM
    assert suspicion.robot is not None
    np.testing.assert_array_equal(suspicion.robot.geometry, sound.robot.geometry)


@pytest.mark.parametrize(("kind", "joint", "by"), [("a", 2, 20.0), ("a", 3, -20.0), ("d", 5, 25.0)])
def test_a_length_that_alone_is_far_from_the_table_is_said(tracked, kind, joint, by):
    """A length mistyped by two centimetres is stated by the calibration, and the table is asked about it; the sound table is not."""
    geometry = tracked.robot.geometry.copy()
    geometry[GEOMETRY.index(kind), joint - 1] += by * MM
    told = calibrate(replace(tracked, robot=tracked.robot.with_geometry(geometry))).summary["setup"]
    assert [(s["what"], s["where"]) for s in told] == [("robot", f"{kind}_{joint}")]
    comes_out = float(re.search(r"comes out ([\d.]+) mm", told[0]["sentence"]).group(1))
    assert comes_out == pytest.approx(abs(by), abs=5)  # the arm itself differs from its table by up to 4 mm
    assert not calibrate(tracked).summary["setup"]


def test_the_table_of_another_arm_is_said_with_all_lengths_and_the_arm_that_was_measured(tracked):
    """Where two lengths are far from the table, both are stated, and the arm of the library that has the measured ones is named."""
    geometry = tracked.robot.geometry.copy()
    geometry[GEOMETRY.index("a"), 2] += 40 * MM
    geometry[GEOMETRY.index("d"), 3] += 25 * MM
    (told,) = calibrate(replace(tracked, robot=tracked.robot.with_geometry(geometry))).summary["setup"]
    assert told["where"] == "a_3" and re.search(r"\(d_4 \d\d mm as well\)", told["sentence"])
    assert "denso_vs060" in told["sentence"]


def test_a_table_of_another_version_is_said_with_the_arm_that_was_measured():
    """The lengths of a UR5e are those of a UR5 but for 24 mm of d_4, and the library's arm is named; where its own table is stated, nothing is."""
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (80, 6))
    q[:, 4] += 1.6
    T = np.eye(4)
    T[:3, 3] = 0.03, 0.02, 0.1
    arms = {name: Robot.from_mapping(read_arm(name).mapping) for name in ("ur5", "ur5e")}
    points = (arms["ur5"].flange(q) @ T)[:, :3, 3] + np.random.default_rng(3).normal(0.0, 5e-5, (80, 3))
    sensor = Sensor(kind="tracker", T_flange_sensor=T, noise=5e-5)
    told = {
        name: calibrate(Dataset.from_arrays(robot=robot, sensor=sensor, q=q, points=points)).summary["setup"]
        for name, robot in arms.items()
    }
    assert not told["ur5"]
    assert [s["where"] for s in told["ur5e"]] == ["d_4"] and "('ur5' of the library)" in told["ur5e"][0][
        "sentence"
    ]


def test_a_slipped_digit_is_named(tracked):
    """A length that was typed ten times too long is named with both numbers, and the corrected table is the right one."""
    geometry = tracked.robot.geometry.copy()
    geometry[GEOMETRY.index("a"), 2] *= 10.0
    with pytest.raises(WrongSetup) as refused:
        calibrate(replace(tracked, robot=tracked.robot.with_geometry(geometry)))
    (suspicion,) = refused.value.suspicions
    length = geometry[GEOMETRY.index("a"), 2] / MM
    assert suspicion.what == "length_digit" and suspicion.where == "a_3"
    assert f"ten times too long: it is {length:.6g} mm" in suspicion.sentence
    assert suspicion.robot is not None
    np.testing.assert_allclose(suspicion.robot.geometry, tracked.robot.geometry, rtol=1e-12)


def test_lengths_are_named_by_the_rows_of_the_user_s_table(tracked):
    """In standard DH each alternative changes the sign of the number that it names, and of no other."""
    dataset = replace(tracked, robot=read_as_standard(tracked.robot))
    before = stated_mapping(dataset.robot)["joints"]
    found = list(length_signs(dataset))
    assert {"a 3", "d 4"} <= {alternative.where for alternative in found}
    for alternative in found:
        kind, row = alternative.where.split()
        after = stated_mapping(alternative.dataset.robot)["joints"]
        changed = {
            (name, i)
            for i, (one, other) in enumerate(zip(before, after, strict=True), start=1)
            for name in ("a", "alpha", "d", "theta")
            if one[name] != other[name]
        }
        assert changed == {(kind, int(row))}


@pytest.mark.parametrize(
    ("degrees", "joints"),
    [
        ((-90, 90), (2, 3)),
        pytest.param((90, -90), (3, 5), marks=pytest.mark.slow),
        pytest.param((75, 90), (2, 4), marks=pytest.mark.slow),
    ],
)
def test_two_wrong_zeros_are_named_together(tracked, degrees, joints):
    """Both angles are stated as the fit has them, and the corrected table explains the data."""
    moved = {f"q{j}": tracked.q[:, j - 1] - angle * DEG for j, angle in zip(joints, degrees, strict=True)}
    wrong = replace(tracked, poses=tracked.poses.assign(**moved))
    with pytest.raises(WrongSetup) as refused:
        calibrate(wrong)
    where = f"joints {joints[0]} and {joints[1]}"
    suspicion = {s.where: s for s in refused.value.suspicions}[where]
    assert suspicion.what == "joint_zero" and suspicion.robot is not None
    stated = re.search(r"are off by (\S+) and (\S+) degrees", suspicion.sentence).groups()
    np.testing.assert_allclose([float(angle) for angle in stated], degrees, atol=2.0)
    assert calibrate(replace(wrong, robot=suspicion.robot)).residual_rms < 1 * MM


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1.03, "% longer than dataset.yaml"), (0.97, "% shorter than dataset.yaml"), (1.002, "")],
)
def test_measurements_that_are_all_too_long_blame_no_single_length(factor, words):
    """The factor is stated, and what may cause it; a factor that the errors of a table have is not."""
    sound = make_scene(
        "ur10e", "tracker", poses_per_plane=25, noise=1e-4, seed=7, length_error=5e-4, angle_error=1e-3
    ).dataset
    told = calibrate(replace(sound, points=factor * sound.points)).summary["setup"]
    assert [entry["what"] for entry in told] == (["stretched_lengths"] if words else [])
    assert all(words in entry["sentence"] for entry in told)


@pytest.mark.parametrize(("factor", "words"), [(1.45, "no two units differ"), (10.0, "look at the unit")])
def test_a_factor_that_no_units_have_is_no_unit(factor, words):
    """A robot of another size is named in place of millimetres and inches."""
    assert words in _what_to_look_at(factor) and words in _what_to_look_at(1 / factor)
