"""Two targets whose names are exchanged, in single poses or from a pose on, are said to be that, and not that a reflector or a pose is wrong."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.sensor.exchanged_names import names_exchanged_in_words, with_names_exchanged
from scalar.estimation.setup.suspicion import WrongSetup
from tests.tracked_targets import drawn_arm

FAR = re.compile(r"it lies (\S+) mm from where a fit to the others has it, and as written (\S+) mm")


@pytest.fixture(scope="module")
def sound() -> Dataset:
    """Return fifty poses of an arm with two targets."""
    rng = np.random.default_rng(3)
    arm = drawn_arm(rng, ("left", "right"))
    return arm.dataset(arm.poses(50, rng), rng, noise=2e-5)


def exchanged(dataset: Dataset, rows) -> Dataset:
    """Return the dataset with the points of the two targets exchanged in some poses, independently of how it is found."""
    points = dataset.points.copy()
    for row in np.atleast_1d(rows):
        first = int(dataset.starts[row])
        points[[first, first + 1]] = points[[first + 1, first]]
    return replace(dataset, points=points)


def test_single_poses_with_exchanged_names_are_told_from_gross_errors(sound):
    """Of three poses that contradict the others, two are said to have their names exchanged, and one to be wrong."""
    spoilt = exchanged(sound, [7, 31])
    points = spoilt.points.copy()
    points[spoilt.starts[20] : spoilt.starts[21]] += [0.2, 0.0, 0.1]
    with pytest.raises(InvalidInput) as refusal:
        calibrate(replace(spoilt, points=points))
    said = {fault.message: fault for fault in refusal.value.faults}
    named = [
        message for message in said if "names 'left' and 'right' of the targets are exchanged" in message
    ]
    assert sorted(m.split(" the names")[0] for m in named) == sorted(
        f"in pose {sound.pose_ids[row]}" for row in (7, 31)
    )
    assert {said[message].file for message in named} == {"points.csv"}
    for message in named:
        then, written = (float(number) for number in FAR.search(message).groups())
        assert then < 0.5 and written > 10
    (other,) = set(said) - set(named)
    assert (
        other.startswith(f"pose {sound.pose_ids[20]} contradicts all others")
        and said[other].file == "poses.csv"
    )


def test_names_that_are_exchanged_from_a_pose_on_are_no_other_target(sound):
    """The pose is the first with exchanged names; no reflector is said to sit elsewhere, and the file is that of the measurements."""
    spoilt = exchanged(sound, np.arange(28, 50))
    with pytest.raises(WrongSetup) as refused:
        calibrate(spoilt)
    (suspicion,) = refused.value.suspicions
    assert suspicion.what == "exchanged_names"
    assert f"from pose {sound.pose_ids[28]} on the names 'left' and 'right'" in suspicion.sentence
    assert [fault.file for fault in refused.value.faults] == ["points.csv"]
    mended = with_names_exchanged(spoilt, np.arange(50) >= 28, "left", "right")
    assert calibrate(mended).residual_rms < 1e-4


def test_many_poses_with_exchanged_names_are_one_sentence(sound):
    """Every third pose is named, in one line that counts them."""
    rows = np.arange(0, sound.n_poses, 3)
    with pytest.raises(InvalidInput) as refusal:
        calibrate(exchanged(sound, rows))
    (fault,) = refusal.value.faults
    ids = ", ".join(str(pose) for pose in sound.pose_ids[rows])
    assert f"in {len(rows)} poses ({ids}) the names 'left' and 'right'" in fault.message


def test_only_several_targets_have_names_that_may_be_exchanged(sound):
    """Nothing is said of a dataset with one target, or where no pose contradicts the others."""
    model = calibrate(sound).model
    none = np.zeros(sound.n_poses, dtype=bool)
    one = replace(sound, targets=(), point_columns={})
    for dataset, rows in ((sound, none), (one, ~none)):
        explained, sentences = names_exchanged_in_words(dataset, model, rows, np.zeros(sound.n_poses))
        assert not explained.any() and sentences == []


def test_names_exchanged_in_all_poses_are_asked_about(sound):
    """If the second target sits where the first is stated to be, that is said; if each sits where it belongs, nothing is."""
    assert not calibrate(sound).summary["setup"]
    (told,) = calibrate(exchanged(sound, np.arange(sound.n_poses))).summary["setup"]
    assert told["what"] == "sensor_pose"
    assert "the target 'left', the first of points.csv" in told["sentence"]
    assert "'right' sits" in told["sentence"] and "the two names are exchanged" in told["sentence"]


def test_names_of_three_targets_that_change_places_in_a_cycle_are_named():
    """From a pose on each target is written with the name of the next; the sentence says which is meant by which."""
    rng = np.random.default_rng(4)
    arm = drawn_arm(rng, ("a", "b", "c"))
    dataset = arm.dataset(arm.poses(50, rng), rng, noise=5e-5, stated={"noise": 5e-5})
    later = np.repeat(np.arange(50) >= 30, np.diff(dataset.starts))
    index = dataset.point_columns["target"].astype(int)
    wrong = np.where(later, (index + 1) % 3, index)
    with pytest.raises(WrongSetup) as refused:
        calibrate(replace(dataset, point_columns={**dataset.point_columns, "target": wrong}))
    (suspicion,) = refused.value.suspicions
    assert f"from pose {dataset.pose_ids[30]} on the names of 3 targets are exchanged" in suspicion.sentence
    assert all(f"'{one}' stands for '{other}'" in suspicion.sentence for one, other in ("ba", "cb", "ac"))
