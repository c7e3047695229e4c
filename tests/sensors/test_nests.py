"""Reference nests on the base show how a tracker moves, and no motion if it stands still."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import read_dataset, validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.references import References
from scalar.effects.target_drift import TargetDrift
from scalar.estimation.calibrate import calibrate
from scalar.estimation.measured_effects import with_target_motion
from scalar.sensors.observed_motion import motion_of_base, observed_motion
from tests import kinematics, small_datasets
from tests.tracked_targets import drawn_arm, relative


def moved(points, motion):
    """Return points ``(N, 3)`` turned by ``motion[:, :3]`` [rad] about the tracker and shifted by ``motion[:, 3:]`` [m]."""
    return np.array(
        [
            kinematics.rotate_about(w, float(np.linalg.norm(w))) @ p + t
            for p, w, t in zip(points, motion[:, :3], motion[:, 3:], strict=True)
        ]
    )


def campaign(seed, nests=3, size=1.0, noise=2e-5, n=60):
    """Return a simulated arm, the dataset of a campaign in which the tracker drifts and settles, with its nests, and the generator."""
    rng = np.random.default_rng(seed)
    arm = drawn_arm(rng, ("A",))
    q = arm.poses(n, rng)
    dataset = arm.dataset(q, rng, noise=noise, stated={"noise": noise})
    share = 1 - np.exp(-np.linspace(0, 2, n))
    motion = size * share[:, None] * rng.normal(size=6) * np.array([3e-5, 3e-5, 3e-5, 2e-4, 2e-4, 2e-4])
    motion += 1e-12
    places = (arm.T_tracker_base[0] @ np.c_[rng.uniform(-0.4, 0.4, (nests, 3)), np.ones(nests)].T).T[:, :3]
    seen = {
        f"nest_{k}": moved(np.tile(p, (n, 1)), motion) + noise * rng.normal(size=(n, 3))
        for k, p in enumerate(places)
    }
    dataset = replace(dataset, points=moved(dataset.points, motion), references=References.of_arrays(seen))
    return arm, dataset, rng


def error(calibration, arm, rng):
    """Return the root mean square error of predicted positions [m] at new poses, after aligning by the motion that the base leaves free."""
    q = arm.poses(60, rng)
    true = arm.at(q, "A")
    return float(np.sqrt(np.mean((relative(calibration.predict(q), true) - true)[:, :3, 3] ** 2)))


def test_csv_and_parquet_of_nests_are_ambiguous(tmp_path):
    """With two files of nests neither is chosen; the dataset is refused, as it is with two files of points."""
    folder = tmp_path / "cell"
    campaign(1)[1].write(folder)
    pd.read_csv(folder / "nests.csv").to_parquet(folder / "nests.parquet")
    (fault,) = validate_dataset(folder)
    assert "only one can be meant" in fault.message and "nests" in fault.file


def test_nests_without_names_are_refused(tmp_path):
    """If the column that names the nests is missing or has another name, the folder is refused with this column's name."""
    folder = tmp_path / "cell"
    campaign(1)[1].write(folder)
    table = (folder / "nests.csv").read_text()
    (folder / "nests.csv").write_text(table.replace("nest,", "abc,", 1))
    assert "nest" in {fault.column for fault in validate_dataset(folder)}


def test_the_motion_of_the_tracker_is_corrected():
    """With three nests a calibration predicts about as well as if the tracker stood still, and without them it does not."""
    arm, dataset, _ = campaign(1, size=4.0)
    still = campaign(1, size=0.0)[1]
    errors = [
        error(calibrate(d), arm, np.random.default_rng(2))
        for d in (dataset, replace(dataset, references=None), still)
    ]
    assert errors[0] < 1.5 * errors[2]
    assert errors[1] > 2 * errors[2]
    (effect,) = calibrate(dataset).model.effects
    assert effect.name == "target_drift" and effect.by == "references"


def test_the_arm_shows_the_same_motion_as_the_nests():
    """Estimated from the arm's own residual, the coefficient of the nests' motion is 1 within three standard errors."""
    dataset = with_target_motion(campaign(3)[1])
    drift = TargetDrift.measured(dataset)
    assert drift is not None
    calibration = calibrate(dataset, effects=[drift.with_coefficients([0.0])])
    (value,), ((std,),) = calibration.model.effects[0].coefficients, calibration.effect_std
    assert std < 0.2
    assert abs(value - 1) < 3 * std


@pytest.mark.parametrize("nests", [1, 3])
def test_nests_that_stand_still_show_nothing(nests):
    """Over thirty seeds of noise alone, no motion is found, and the noise is estimated to 30 %."""
    for seed in range(30):
        rng = np.random.default_rng(seed)
        seen = {str(k): rng.normal(size=3) + 3e-5 * rng.normal(size=(50, 3)) for k in range(nests)}
        found = observed_motion(References.of_arrays(seen))
        assert found.p_value > 1e-4 and not found.screws.any()
        assert 0.7 < found.noise / 3e-5 < 1.3


@pytest.mark.parametrize("poses", [1, 2, 3])
def test_a_session_of_few_poses_shows_what_it_can(poses):
    """A session may have two poses, or one, which shows no motion; the sessions before and after it are found as they are without it."""
    rng = np.random.default_rng(6)
    places = {str(k): rng.normal(size=3) for k in range(3)}
    shift = np.outer(np.linspace(0, 1, 40), [3e-4, -2e-4, 1e-4])
    seen = {name: place + shift + 1e-5 * rng.normal(size=shift.shape) for name, place in places.items()}
    session = np.where(np.arange(40) < 40 - poses, 0, 1)
    frames = np.broadcast_to(np.eye(4), (2, 4, 4))
    references = References.of_arrays(seen)
    found = motion_of_base(references, session, frames)
    rows = np.flatnonzero(session == 0)
    alone = motion_of_base(references.subset(rows, 40), session[rows], frames[:1])
    np.testing.assert_array_equal(found[rows], alone)
    assert alone.any() and np.isfinite(found).all()
    assert poses > 1 or not found[session == 1].any()


def test_motion_is_interpolated_at_poses_without_nests():
    """At poses at which some or all nests were not measured, the motion is found to a few times the noise."""
    rng = np.random.default_rng(4)
    n = 80
    shift = np.outer(np.sin(np.linspace(0, 3, n)), [3e-4, -2e-4, 1e-4])
    seen = {}
    for k in range(3):
        places = rng.normal(size=3) + shift + 1e-5 * rng.normal(size=(n, 3))
        places[rng.random(n) < 0.5] = np.nan
        seen[str(k)] = places
    references = References.of_arrays(seen)
    found = observed_motion(references)
    points = np.array([0.5, 0.2, 0.1]) + np.zeros((len(found.screws), 3))
    at = found.screws[:, 3:] + np.cross(found.screws[:, :3], points)
    off = at - shift[: len(at)]
    assert np.sqrt(np.mean((off - off.mean(axis=0)) ** 2)) < 4e-5


def test_nests_are_read_as_they_were_written(tmp_path):
    """A folder in which some poses have nests is valid and reads back; a subset of its poses keeps their nests."""
    dataset = campaign(5, n=12)[1]
    kept = dataset.references.subset(np.flatnonzero(np.arange(12) % 5), 12)
    rows = np.flatnonzero(np.arange(12) % 5)
    dataset = replace(dataset, references=replace(kept, pose=rows[kept.pose]))
    dataset.write(tmp_path / "d")
    assert validate_dataset(tmp_path / "d") == []
    again = read_dataset(tmp_path / "d")
    for name in ("pose", "item", "points"):
        np.testing.assert_array_equal(getattr(again.references, name), getattr(dataset.references, name))
    part = again.subset(np.array([2, 5, 7])).references
    np.testing.assert_array_equal(np.unique(part.pose), [0, 2])  # pose 5 has none


@pytest.mark.parametrize(
    ("columns", "row", "column", "said"),
    [
        ({"pose": 99}, 2, "pose", "unknown pose 99"),
        ({"nest": ["a"] * 2}, 3, "nest", "already in row 2"),
        ({"x": 2000.0}, 2, "x", "millimetres"),
        ({"noise": 0.0}, 2, "noise", "greater than 0"),
        ({"height": 1.0}, 1, "height", "unknown column"),
    ],
)
def test_faults_of_nests_are_named(tmp_path, columns, row, column, said):
    """Every wrong cell or column of nests.csv is refused by its row and column."""
    tables = small_datasets.tables("tracker")
    nests = pd.DataFrame({"pose": [10, 10], "nest": ["a", "b"], "x": 0.1, "y": 0.2, "z": 0.3}).assign(
        **columns
    )
    write_dataset(tmp_path / "d", mapping=small_datasets.description("tracker"), **tables, nests=nests)
    found = [fault for fault in validate_dataset(tmp_path / "d") if fault.file == "nests.csv"]
    assert (found[0].row, found[0].column) == (row, column)
    assert said in found[0].message


def test_validate_says_how_often_each_nest_was_measured(tmp_path):
    """The summary of a folder counts the measurements of every nest."""
    campaign(6, nests=2, n=12)[1].write(tmp_path / "d")
    said = CliRunner().invoke(cli, ["validate", str(tmp_path / "d")])
    assert said.exit_code == 0, said.output
    assert "nests: nest_0 12, nest_1 12" in said.output


def with_wrong_readings(folder, wrong):
    """Write a campaign of 60 poses with three nests of which some readings are 0.2 m off; ``wrong`` lists them as (pose, nest)."""
    campaign(4)[1].write(folder)
    nests = pd.read_csv(folder / "nests.csv")
    for pose, nest in wrong:
        nests.loc[(nests.pose == pose) & (nests.nest == nest), ["x", "y"]] += [0.2, 0.1]
    nests.to_csv(folder / "nests.csv", index=False)
    return nests


def test_a_reading_of_another_reflector_is_named(tmp_path):
    """A reading that does not keep its distances to the other nests is refused with its row, nest and pose, and no other one is."""
    folder = tmp_path / "cell"
    wrong = [(2, "nest_1"), (30, "nest_0"), (31, "nest_0")]
    nests = with_wrong_readings(folder, wrong)
    faults = validate_dataset(folder)
    rows = [int(np.flatnonzero((nests.pose == pose) & (nests.nest == nest))[0]) + 2 for pose, nest in wrong]
    assert sorted(fault.row for fault in faults) == sorted(rows)
    assert all("keep their distances" in fault.message and fault.file == "nests.csv" for fault in faults)


@pytest.mark.parametrize("moved_by", [3e-3, 0.02])
def test_a_nest_that_is_knocked_in_the_middle_is_named_once(tmp_path, moved_by):
    """In nearly half of the poses it is elsewhere: one sentence names it, with the first and the last of these poses."""
    folder = tmp_path / "cell"
    campaign(4)[1].write(folder)
    nests = pd.read_csv(folder / "nests.csv")
    later = (nests.pose > 32) & (nests.nest == "nest_1")
    nests.loc[later, ["x", "y", "z"]] += moved_by * np.array([0.6, 0.0, 0.8])
    nests.to_csv(folder / "nests.csv", index=False)
    (fault,) = validate_dataset(folder)
    assert fault.message.startswith("nest_1 is up to") and "the first 33 and the last 60" in fault.message


def test_a_tracker_that_is_knocked_keeps_the_distances_of_nests(tmp_path):
    """A motion of centimetres in the middle of a campaign changes no distance and is no fault of the nests; nor is the drift of other campaigns."""
    folder = tmp_path / "cell"
    campaign(4)[1].write(folder)
    assert not validate_dataset(folder)
    nests = pd.read_csv(folder / "nests.csv")
    later = nests.pose >= 30
    turn = np.tile([0.0, 0.0, 0.02, 0.03, -0.05, 0.01], (int(later.sum()), 1))
    nests.loc[later, ["x", "y", "z"]] = moved(nests.loc[later, ["x", "y", "z"]].to_numpy(), turn)
    nests.to_csv(folder / "nests.csv", index=False)
    assert not validate_dataset(folder)
