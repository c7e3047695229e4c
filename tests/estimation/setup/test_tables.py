"""Errors in the tables of a set-up: angles from the horizontal, lengths in inches, and rows that do not belong together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.errors import Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.units import MM
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def tracked() -> Dataset:
    """Return a sound dataset of seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset


@pytest.fixture(scope="module")
def scanned() -> Dataset:
    """Return a sound dataset of ninety scans."""
    return make_scene("vs060", poses_per_plane=30, points_per_scan=12, noise=1e-4, seed=5).dataset


def with_columns(dataset: Dataset, **columns: np.ndarray) -> Dataset:
    return replace(dataset, poses=dataset.poses.assign(**columns))


@pytest.mark.slow
@pytest.mark.parametrize(("sign", "remedy"), [(1, "write q3 minus q2"), (-1, "write q3 plus q2")])
def test_an_angle_that_is_counted_from_the_horizontal_is_named(tracked, sign, remedy):
    """If the angle of joint 3 contains that of joint 2, or its negative, one sentence says so, and what to write instead."""
    coupled = with_columns(tracked, q3=tracked.q[:, 2] + sign * tracked.q[:, 1])
    with pytest.raises(WrongSetup) as refused:
        calibrate(coupled)
    (suspicion,) = refused.value.suspicions
    assert (suspicion.what, suspicion.where) == ("coupled_joints", "joints 2 and 3")
    assert (
        remedy in suspicion.sentence and f"'{remedy.split()[2]}' in the mapping of q3" in suspicion.sentence
    )
    assert suspicion.rms_after is not None and suspicion.rms_after < 1 * MM


@pytest.mark.slow
def test_the_angle_of_a_motor_in_a_coupled_wrist_is_named(tracked):
    """Axes 5 and 6 are not parallel, and the sentence speaks of drives."""
    coupled = with_columns(tracked, q6=tracked.q[:, 5] + tracked.q[:, 4])
    with pytest.raises(
        WrongSetup, match=r"q6 of poses\.csv contains q5: the drives of joints 5 and 6 are coupled"
    ):
        calibrate(coupled)


@pytest.mark.slow
def test_an_angle_that_contains_those_of_two_parallel_joints_is_named():
    """The fourth joint of an arm with three parallel ones, counted from the ground."""
    dataset = make_scene("ur10e", "tracker", poses_per_plane=25, noise=1e-4, seed=3).dataset
    coupled = with_columns(dataset, q4=dataset.q[:, 1:4].sum(axis=1))
    with pytest.raises(WrongSetup, match="write q4 minus q2 minus q3 into the column q4"):
        calibrate(coupled)


@pytest.mark.slow
@pytest.mark.parametrize(("unit", "metres"), [("inches", 0.0254), ("centimetres", 0.01)])
def test_lengths_that_were_never_converted_are_named(scanned, unit, metres):
    """Scans in inches or centimetres that stand in a table of metres are recognised as what they are."""
    with pytest.raises(WrongSetup) as refused:
        calibrate(replace(scanned, points=scanned.points / metres))
    assert f"({unit}?)" in refused.value.suspicions[0].sentence


def test_planes_are_not_blamed_for_a_fit_that_failed(scanned):
    """Where angles and scans do not belong together, no plane is said to lie elsewhere than its guess, and nothing is calibrated."""
    for seed in range(3):
        shuffled = np.random.default_rng(seed).permutation(scanned.n_poses)
        mixed = with_columns(scanned, **{f"q{j + 1}": scanned.q[shuffled, j] for j in range(6)})
        with pytest.raises(Undetermined, match=r"belong together|ran "):
            calibrate(mixed, explain=False)


def with_link(dataset: Dataset, change: float) -> Dataset:
    """Return the dataset with a_3 in the table of joints longer by ``change`` [m]."""
    geometry = dataset.robot.geometry.copy()
    geometry[0, 2] += change
    return replace(dataset, robot=replace(dataset.robot, geometry=geometry))


@pytest.mark.parametrize("kind", ["tracker", "line-laser", "probe"])
@pytest.mark.parametrize(("change", "is_named"), [(0.0, False), (90 * MM, True)])
def test_a_link_that_is_wrong_in_the_table_is_named(kind, change, is_named):
    """A link 90 mm too long in the table is calibrated, and named; where no length is known, either it or another length is said to be wrong."""
    sound = make_scene("vs060", kind, poses_per_plane=25, points_per_scan=12, noise=2e-5, seed=5).dataset
    setup = calibrate(with_link(sound, change), explain=False).summary["setup"]
    sentences = [entry["sentence"] for entry in setup if "table of joints" in entry["sentence"]]
    assert bool(sentences) == is_named
    assert all("a_3" in sentence for sentence in sentences)
    assert all(("all lengths are relative" in sentence) == (kind == "probe") for sentence in sentences)
