"""Spoiled set-ups: what is simulated is sound, what is spoiled is wrong beyond a move, and what is said is scored against what was done."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from study.common.kinematics import random_transform, rotation
from study.spoiled_setups.beyond_moves import least_change
from study.spoiled_setups.campaign import flange_frames, in_standard_rows
from study.spoiled_setups.design import ONLY_WITH, SCANNER, TRACKER, Design, load_spoiled
from study.spoiled_setups.run import COLUMNS, change_of, drawn, run_setup
from study.spoiled_setups.score import CRASHED, DOUBTED, OUTCOMES, REFUSED, RIGHT, SILENT, WRONG, outcome_of
from study.spoiled_setups.spoilings import SPOILINGS, Truth, spoil
from study.spoiled_setups.summaries import summarise_spoiled
from study.spoiled_setups.workcell import OutOfReach, measured_points, workcell

from scalar.data.dataset import read_dataset
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.robots import arm_names, read_arm

CONFIG = "configs/spoiled_setups.yaml"


@pytest.fixture(scope="module")
def design(request):
    """Return the committed design."""
    return load_spoiled(request.config.rootpath / CONFIG)


def sound(design, kind, sensor, number=0):
    """Return a sound workcell with a sensor, what was drawn for it, and the random numbers that come next."""
    for attempt in range(50):
        setup, rng = design.drawn(number, attempt)
        setup = replace(setup, kind=kind, sensor=sensor, poses=40, states_pose=True)
        try:
            return workcell(setup, rng), rng
        except OutOfReach:
            continue
    raise AssertionError("no arm reaches the planes")


def test_a_table_in_standard_rows_is_the_same_arm():
    """The flange stands at the same place by both conventions, for every arm of the library."""
    rng = np.random.default_rng(1)
    for arm in map(read_arm, arm_names()):
        q = rng.uniform(-3, 3, (5, arm.robot.n_joints))
        frames = flange_frames(arm.mapping, q)
        np.testing.assert_allclose(flange_frames(in_standard_rows(arm.mapping), q), frames, atol=1e-12)


@pytest.mark.parametrize("sensor", [SCANNER, TRACKER])
def test_a_sound_campaign_is_calibrated_without_a_word(design, sensor, tmp_path):
    """What is written is read back, the noise explains the residual, and nothing of the set-up is doubted."""
    cell, _ = sound(design, "joint_sign", sensor)
    summary = calibrate(read_dataset(cell.campaign.write(tmp_path / "set"))).summary
    assert not summary.get("setup")
    assert 0.7 < summary["misfit"] < 1.4


def test_moves_of_base_and_sensor_change_nothing_and_a_sign_does():
    """The change is zero for any rigid motions before and after an arm, and for zeros of its first and last joint."""
    rng = np.random.default_rng(2)
    robot = read_arm("denso_vs060").mapping
    q = rng.uniform(-1.5, 1.5, (30, 6))
    right, points = flange_frames(robot, q), np.vstack([np.zeros(3), 0.3 * np.eye(3)])
    moved = random_transform(rng, 2.0, 1.0) @ right @ random_transform(rng, 0.1, 0.3)
    assert least_change(right, moved, points) < 1e-4
    for joint in (0, 5):
        turned = flange_frames(robot, q + 1.3 * np.eye(6)[joint])
        assert least_change(right, turned, points) < 1e-4
        assert least_change(right, turned, points[:1]) < 1e-4
    for joint in range(6):
        counted_back = flange_frames(robot, q * (1.0 - 2.0 * np.eye(6)[joint]))
        assert least_change(right, counted_back, points) > 0.05
    # A half turn about x before and after an arm is a move; one within it is none.
    assert least_change(right, rotation(0, np.pi) @ right @ rotation(0, np.pi), points) < 1e-4


@pytest.mark.parametrize("kind", SPOILINGS)
def test_every_kind_makes_one_thing_wrong(design, kind, tmp_path):
    """The spoiled campaign differs from the sound one in one part alone, beyond a move, and has as many rows of every kind."""
    cell, rng = sound(design, kind, ONLY_WITH.get(kind, TRACKER))
    before = cell.campaign
    for _ in range(20):
        spoiled = spoil(kind, cell, rng)
        change = change_of(cell, spoiled)
        if change is None or change > 5e-3:
            break
    after = spoiled.campaign
    assert change is None or change > 5e-3
    assert len(after.q) == len(after.points) == (len(after.labels) or len(after.q))
    differs = {
        "robot": after.robot != before.robot,
        "labels": after.labels != before.labels,
        "rows": len(after.q) != len(before.q),
        "q": len(after.q) == len(before.q) and not np.array_equal(after.q, before.q),
        "points": len(after.q) == len(before.q) and not np.array_equal(np.concatenate(after.points), np.concatenate(before.points)),
    }  # fmt: skip
    assert sum(differs.values()) == 1, differs
    assert (after.sensor, after.planes) == (before.sensor, before.planes)


def test_shifted_rows_pair_a_measurement_with_the_angles_of_another_pose(design):
    """With rows moved by k, the measurement of pose i stands with the angles of pose i + k, and the sentence has to say on which side."""
    cell, rng = sound(design, "off_by_one", TRACKER)
    for _ in range(6):
        spoiled = spoil("off_by_one", cell, rng)
        k = 1 if "by 1 " in spoiled.done else -1
        first = max(0, -k)
        np.testing.assert_array_equal(spoiled.campaign.points[0], cell.campaign.points[first])
        np.testing.assert_array_equal(spoiled.campaign.q[0], cell.campaign.q[first + k])
        assert spoiled.truth.words == (("pose before",) if k == 1 else ("pose after",))


def test_a_longer_design_begins_with_the_shorter_one_and_takes_kinds_in_turn(design):
    """A set depends on seed and number alone, and each kind has its share."""
    longer = Design({**design.content, "sets": 400})
    kinds = [longer.drawn(number, 0)[0].kind for number in range(22)]
    assert sorted(kinds[:11]) == sorted(SPOILINGS) and kinds[:11] == kinds[11:]
    assert [longer.drawn(number, 0)[0] for number in range(5)] == [
        design.drawn(number, 0)[0] for number in range(5)
    ]
    setup, spoiled, change = drawn(design, 3)
    assert setup.kind == kinds[3] and (change is None or change > design.content["least_change_m"])
    assert len(spoiled.campaign.points) == len(spoiled.campaign.q)


def said(what, where="", sentence=""):
    """Return an entry of what was said."""
    return {"what": what, "where": where, "sentence": sentence}


SIGN = Truth(("joint_sign",), "joint 4")
GRADS = Truth(("angle_unit",), "poses.csv", ("grads",))
ARM = Truth(("other_arm", "robot"), arms=("ur10e", "ur10"))


@pytest.mark.parametrize(
    ("truth", "stage", "entries", "expected"),
    [
        (SIGN, "set-up", [said("joint_sign", "joint 4")], (RIGHT, 1)),
        (SIGN, "set-up", [said("joint_zero", "joint 4"), said("joint_sign", "joint 4")], (RIGHT, 2)),
        (SIGN, "set-up", [said("joint_sign", "joint 5")], (WRONG, 0)),
        (SIGN, "accepted", [said("joint_zero", "joint 3")], (WRONG, 0)),
        (SIGN, "accepted", [said("sensor_pose")], (DOUBTED, 0)),
        (SIGN, "accepted", [], (SILENT, 0)),
        (SIGN, "fit", [said("refusal", "Undetermined", "the best fit is still 50 mm off")], (REFUSED, 0)),
        (SIGN, "crashed", [said("refusal")], (CRASHED, 0)),
        (GRADS, "set-up", [said("angle_unit", "poses.csv", "the joint angles are in degrees")], (WRONG, 0)),
        (GRADS, "set-up", [said("angle_unit", "poses.csv", "the joint angles are in grads")], (RIGHT, 1)),
        (GRADS, "read", [said("refusal", "InvalidInput", "are these degrees? write radians")], (WRONG, 0)),
        (ARM, "accepted", [said("robot", "a_2", "is this another robot?")], (RIGHT, 1)),
        (ARM, "set-up", [said("other_arm", "robot", "the UR10 ('ur10' of the library) fits")], (RIGHT, 1)),
        (ARM, "set-up", [said("length_unit", "points.csv", "the axes are those of 'ur10e' of the library")], (RIGHT, 1)),
        (ARM, "set-up", [said("other_arm", "robot", "the UR5 ('ur5' of the library) fits")], (WRONG, 0)),
    ],
)  # fmt: skip
def test_what_is_said_is_scored_against_what_was_done(truth, stage, entries, expected):
    """A name is right with its place, unit and arm alone; doubts are no names; silence is counted apart."""
    assert outcome_of(truth, stage, entries) == expected


def test_a_set_is_drawn_spoiled_and_named(design):
    """A mirrored tracker is drawn, refused and named, in a row with every column."""
    number = design.content["kinds"].index("mirrored")
    row = run_setup(design, number)
    assert set(row) <= set(COLUMNS)
    assert (row["exit"], row["outcome"], row["change_mm"]) == (2, RIGHT, None)


def test_summaries_count_every_set_once(design):
    """The outcomes of each kind add up to its sets, those of all kinds to all, and only sets not named right are listed."""
    rows = [
        {"kind": kind, "sensor": sensor, "outcome": outcome, "one_of": 1 if outcome == RIGHT else 0, "attempt": 0, "seconds": 1.0}
        for kind in ("joint_sign", "mirrored")
        for sensor, outcome in zip([SCANNER, TRACKER] * 3, [*OUTCOMES[:4], RIGHT, RIGHT], strict=True)
    ]  # fmt: skip
    numbers, tables = summarise_spoiled(pd.DataFrame(rows), design.content)
    table = tables["table"].set_index(["kind", "sensor"])
    assert (table[list(OUTCOMES)].sum(axis=1) == table["sets"]).all()
    assert table.loc[("mirrored", "all"), RIGHT] == 3 and numbers["sets"] == 12
    assert numbers["share_right"] == 0.5 and numbers["low"] < 0.5 < numbers["high"]
    assert len(tables["faults"]) == 6 and RIGHT not in set(tables["faults"]["outcome"])


def test_a_design_with_a_wrong_key_is_refused(tmp_path, request):
    """The fault names the file and the key."""
    text = (request.config.rootpath / CONFIG).read_text(encoding="utf-8")
    (tmp_path / "wrong.yaml").write_text(text.replace("standard: 0.5", "standard: 5"), encoding="utf-8")
    with pytest.raises(InvalidInput, match=r"wrong\.yaml.*standard"):
        load_spoiled(tmp_path / "wrong.yaml")


def test_a_tracker_depends_on_one_point_and_a_scanner_on_a_frame(design):
    """What has to move for a change to count is the target's origin, or the scanner's origin and axes."""
    assert len(measured_points(sound(design, "joint_sign", TRACKER)[0])) == 1
    assert len(measured_points(sound(design, "joint_sign", SCANNER)[0])) == 4
