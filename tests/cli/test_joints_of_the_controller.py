"""``--mapping`` of plan, correct and predict: joint angles as the controller counts them, against conversions that are written out by hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.cli.pose_lines import lines_on_limits
from scalar.data.dataset import read_dataset
from scalar.data.io.plain_yaml import dump_yaml
from scalar.estimation.result import load_calibration
from scalar.ingest.controller_joints import controller_joints
from tests.cli.correcting import FRAME, JOINTS, run
from tests.random_scene import make_scene
from tests.small_datasets import description


def mapping_of(**changes):
    """Return a mapping of a controller that shows joint 3 against the horizontal and counts joint 5 the other way, from another zero."""
    columns = {f"q{i}": {"column": f"J{i}", "unit": "deg"} for i in range(1, 7)}
    columns["q3"]["plus"] = "J2"
    columns["q5"] |= {"sign": -1, "offset": 90}
    columns |= {name: {"column": name, "unit": "mm"} for name in "xyz"}
    for name, keys in changes.items():
        columns[name] = columns.get(name, {}) | keys
    return {"format": "scalar-mapping/1", "poses": {"columns": columns}, "dataset": description("tracker")}


def written(folder: Path, **changes) -> Path:
    """Write the mapping, and return its path."""
    dump_yaml(mapping_of(**changes), folder / "controller.yaml")
    return folder / "controller.yaml"


def shown(q):
    """Return the joints ``(N, 6)`` [rad] that this controller shows."""
    return np.column_stack([q[:, 0], q[:, 1], q[:, 2] - q[:, 1], q[:, 3], np.pi / 2 - q[:, 4], q[:, 5]])


def of_controller(program):
    """Write the program as the controller has it, in degrees and with directions of approach as it counts joint 5; return its file."""
    table = pd.read_csv(program / "targets.csv")
    table[JOINTS] = np.rad2deg(shown(table[JOINTS].to_numpy()))
    table["approach5"] *= -1
    table.to_csv(program / "controller.csv", index=False, float_format="%.17g")
    return program / "controller.csv"


def test_programs_of_the_controller_are_corrected_and_predicted_as_those_of_the_dataset(program):
    """The same frames and the same corrections result, and the other columns are copied with the controller's directions."""
    mapping, controller, calibration = written(program), of_controller(program), program / "calibration.json"
    options = ("--units", "deg,mm", "--mapping", mapping)
    status, said = run("predict", calibration, controller, "-o", program / "a.csv", *options)
    assert status == 0 and "q3 = J3 + J2, q5 = -J5 + 90 deg, by controller.yaml" in said, said
    assert run("predict", calibration, program / "targets.csv", "-o", program / "b.csv")[0] == 0
    size = np.r_[np.full(3, 1e3), np.full(3, np.rad2deg(1))]
    there = pd.read_csv(program / "a.csv")[[f"{c}_{'mm' if c in 'xyz' else 'deg'}" for c in FRAME]]
    np.testing.assert_allclose(there / size, pd.read_csv(program / "b.csv")[FRAME], atol=2e-9)
    status, said = run("correct", calibration, controller, "-o", program / "c.csv", *options)
    assert status == 0, said
    assert run("correct", calibration, program / "targets.csv", "-o", program / "d.csv")[0] == 0
    ours, theirs = pd.read_csv(program / "c.csv"), pd.read_csv(program / "d.csv")
    found = np.deg2rad(ours[[f"{name}_deg" for name in JOINTS]].to_numpy())
    np.testing.assert_allclose(found, shown(theirs[JOINTS].to_numpy()), atol=1e-9)
    np.testing.assert_array_equal(ours["approach5"], -theirs["approach5"])


def test_frames_get_the_joint_angles_of_the_controller(program):
    """The postures that are chosen for wanted frames are written for the controller too."""
    calibration, frames = program / "calibration.json", program / "frames.csv"
    assert run("predict", calibration, program / "targets.csv", "-o", frames)[0] == 0
    further = [f"approach{i}" for i in range(1, 7)] + ["temperature"]
    program_table = pd.read_csv(program / "targets.csv")
    wanted = pd.concat([pd.read_csv(frames), program_table[further]], axis=1)
    wanted.to_csv(program / "wanted.csv", index=False, float_format="%.17g")
    assert run("correct", calibration, program / "wanted.csv", "-o", program / "plain.csv")[0] == 0
    plain = pd.read_csv(program / "plain.csv")
    written(program, approach5={"column": "D5", "sign": 1})
    options = ("-o", program / "shown.csv", "--mapping", program / "controller.yaml")
    status, said = run("correct", calibration, program / "wanted.csv", *options)
    assert status == 0 and "shown.csv has the joint angles of the controller" in said, said
    found = pd.read_csv(program / "shown.csv")[JOINTS].to_numpy()
    np.testing.assert_allclose(found, shown(plain[JOINTS].to_numpy()), atol=1e-9)


def test_a_plan_has_the_joint_angles_of_the_controller_in_degrees(tmp_path):
    """poses_deg.csv is the controller's, and poses.csv stays that of the dataset, so that its rows can be appended."""
    cell = make_scene(seed=4, poses_per_plane=12, points_per_scan=10).write(tmp_path / "cell")
    written(tmp_path)
    options = ("--poses", 30, "--candidates", 120, "--no-collisions", "-o", tmp_path / "plan")
    status, said = run("plan", cell, *options, "--mapping", tmp_path / "controller.yaml")
    assert status == 0 and "poses_deg.csv has the joint angles of the controller" in said, said
    q = pd.read_csv(tmp_path / "plan/poses.csv")[JOINTS].to_numpy()
    degrees = pd.read_csv(tmp_path / "plan/poses_deg.csv")[[f"{name}_deg" for name in JOINTS]].to_numpy()
    np.testing.assert_allclose(degrees, np.rad2deg(shown(q)), atol=1e-4)
    assert run("plan", cell, *options, "--force")[0] == 0
    assert np.array_equal(pd.read_csv(tmp_path / "plan/poses.csv")[JOINTS].to_numpy(), q)


def test_without_a_mapping_it_is_said_that_the_controller_counts_otherwise(tmp_path):
    """The import records which joints it converted, the calibration knows it, and each command that takes or writes joint angles then says which."""
    scene = make_scene("vs060", "tracker", seed=4, poses_per_plane=20)
    imported = {"mapping": "controller.yaml", "joints": "q3 = J3 + J2"}
    replace(scene.dataset, imported=imported).write(tmp_path / "cell")
    assert read_dataset(tmp_path / "cell").imported == imported
    assert run("calibrate", tmp_path / "cell", "-o", tmp_path / "out")[0] == 0
    near = tmp_path / "out/calibration.json"
    scene.dataset.poses[["pose", *JOINTS]].to_csv(tmp_path / "q.csv", index=False)
    mapping = ("--mapping", written(tmp_path))
    for command in (
        ("predict", near, tmp_path / "q.csv", "-o", tmp_path / "a.csv"),
        ("correct", near, tmp_path / "q.csv", "-o", tmp_path / "b.csv", "--leave-out"),
        (
            "plan",
            tmp_path / "cell",
            "--poses",
            12,
            "--candidates",
            100,
            "--no-collisions",
            "-o",
            tmp_path / "p",
        ),
    ):
        status, said = run(*command)
        assert status == 0 and "not those that the controller shows (q3 = J3 + J2" in said, said
        assert "give --mapping controller.yaml" in said
        assert "without --mapping" not in run(*command, *mapping, "--force")[1]


def test_the_library_knows_which_controllers_count_otherwise(tmp_path):
    """A plan for a FANUC of the library is not in the angles that its controller shows, and says so; that of a UR needs no such line."""
    options = ("--poses", 12, "--candidates", 100, "--no-collisions", "-o", tmp_path / "plan", "--force")
    assert "a controller of FANUC shows (q3 = J3 + J2)" in run("plan", "fanuc_lrmate200id", *options)[1]
    assert "--mapping" not in run("plan", "ur5e", *options)[1]


def test_the_import_records_what_it_converts_and_what_nothing_states(tmp_path):
    """dataset.yaml names the mapping, the formulas of the joints, and an order that was not stated; without any of these there is no such key."""
    rows = [
        "J1,J2,J3,J4,J5,J6,x,y,z",
        *(f"{10 * i},{7 * i},{3 * i},{i},{5 * i},{i},{100 * i},{i},{i}" for i in range(1, 9)),
    ]
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    status, said = run("import", written(tmp_path), tmp_path / "log.csv", "-o", tmp_path / "cell")
    assert status == 0, said
    assert read_dataset(tmp_path / "cell").imported == {
        "mapping": "controller.yaml",
        "joints": "q3 = J3 + J2, q5 = -J5 + 90 deg",
        "order": "not stated",
    }
    content = mapping_of()
    del content["poses"]["columns"]["q3"]["plus"]
    content["poses"]["columns"]["q5"] = {"column": "J5", "unit": "deg"}
    content["poses"]["rows_in_order"] = True
    dump_yaml(content, tmp_path / "plain.yaml")
    assert run("import", tmp_path / "plain.yaml", tmp_path / "log.csv", "-o", tmp_path / "plain")[0] == 0
    assert not read_dataset(tmp_path / "plain").imported


@given(
    st.lists(st.sampled_from([1, -1]), min_size=6, max_size=6),
    st.lists(st.floats(-400, 400), min_size=6, max_size=6),
    st.lists(st.one_of(st.none(), st.integers(0, 5)), min_size=6, max_size=6),
    st.integers(0, 2**32 - 1),
)
def test_angles_return_to_1e_12_rad(tmp_path_factory, signs, offsets, added, seed):
    """Whatever signs, zeros and earlier joints a mapping adds or subtracts, the angles of the controller become those of the dataset by the
    formula of the mapping, and return."""
    keys = {}
    for i in range(6):
        keys[f"q{i + 1}"] = {"sign": signs[i], "offset": offsets[i]}
        if added[i] is not None and added[i] < i:
            keys[f"q{i + 1}"]["plus" if seed % 2 else "minus"] = f"J{added[i] + 1}"
    content = mapping_of(**keys)
    if "plus" not in keys["q3"]:
        del content["poses"]["columns"]["q3"]["plus"]
    folder = tmp_path_factory.mktemp("mapping")
    dump_yaml(content, folder / "mapping.yaml")
    convention = controller_joints(folder / "mapping.yaml", content["dataset"]["robot"])
    shown_degrees = np.random.default_rng(seed).uniform(-360, 360, (7, 6))
    q = np.empty((7, 6))
    for i in range(6):
        total = shown_degrees[:, i]
        for key, sign in (("plus", 1), ("minus", -1)):
            if (other := keys[f"q{i + 1}"].get(key)) is not None:
                total = total + sign * shown_degrees[:, int(other[1:]) - 1]
        q[:, i] = np.deg2rad(signs[i] * total + offsets[i])
    found = convention.to_dataset(np.deg2rad(shown_degrees))
    np.testing.assert_allclose(found, q, rtol=0, atol=1e-12)
    np.testing.assert_allclose(convention.to_controller(found), np.deg2rad(shown_degrees), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"q3": {"plus": "payload angle"}}, "'payload angle' is added to q3 and is the column of no joint"),
        (
            {"q2": {"minus": "payload angle"}},
            "'payload angle' is subtracted from q2 and is the column of no joint",
        ),
        ({"q2": {"plus": "J3"}}, "the joints of the controller do not follow from those of the dataset"),
        ({"q2": {"unit": "rad"}}, "'J2' is in rad for q2 and in deg for q3"),
    ],
)
def test_a_mapping_that_cannot_be_inverted_is_refused(program, changes, words):
    """The message names the mapping and the column that is at fault, and nothing is written."""
    mapping = written(program, **changes)
    options = ("-o", program / "out.csv", "--mapping", mapping)
    status, said = run("predict", program / "calibration.json", program / "targets.csv", *options)
    assert status == 2 and words in said and "controller.yaml" in said and "poses.columns" in said, said
    assert not (program / "out.csv").exists()


def test_the_mapping_of_another_arm_is_refused_and_one_without_a_robot_is_taken(program):
    """The number of joints shows another arm; a mapping whose robot came from a URDF takes that of the calibration."""
    content = mapping_of()
    del content["dataset"]["robot"]
    dump_yaml(content, program / "controller.yaml")
    options = ("-o", program / "out.csv", "--mapping", program / "controller.yaml")
    status, said = run(
        "predict", program / "calibration.json", of_controller(program), *options, "--units", "deg"
    )
    assert status == 0, said
    content = mapping_of()
    content["dataset"]["robot"]["joints"].append({"a": 0.0, "alpha": 0.0, "d": 0.1, "theta": 0.0})
    content["poses"]["columns"]["q7"] = {"column": "J7", "unit": "deg"}
    dump_yaml(content, program / "controller.yaml")
    status, said = run("predict", program / "calibration.json", program / "targets.csv", *options, "--force")
    assert status == 2 and "an arm with 7 joints, and this one has 6" in said, said


def test_faults_in_a_joint_that_others_are_added_to_are_named_once(program):
    """A cell of q2 that is no number is named as such, and not as a fault of q3, to which joint 2 is added."""
    table = pd.read_csv(of_controller(program), dtype=str)
    table.loc[3, "q2"] = "?"
    table.to_csv(program / "controller.csv", index=False)
    options = ("-o", program / "out.csv", "--units", "deg,mm", "--mapping", written(program))
    status, said = run("predict", program / "calibration.json", program / "controller.csv", *options)
    assert status == 2 and len(said.splitlines()) == 1 and "row 5" in said and "q2" in said, said


def test_a_limit_is_said_as_the_controller_counts_the_joint(program):
    """Joint 3 against the horizontal may turn from its lower limit less joint 2 on, and joint 5 counts from the other end."""
    calibration = load_calibration(program / "calibration.json")
    robot = calibration.model.robot
    low, high = np.rad2deg(robot.limits.T)
    q = np.zeros((1, 6))
    q[0, 1], q[0, 2], q[0, 4] = np.deg2rad(20.0), np.deg2rad(low[2] - 5.0), np.deg2rad(high[4] + 1.0)
    convention = controller_joints(written(program), calibration.model.nominal.to_mapping())
    (line,) = lines_on_limits(robot, np.array([7]), q, convention)
    of_three = (
        f"joint 3 at {low[2] - 25:.3f} deg is beyond its limits {low[2] - 20:.1f} to {high[2] - 20:.1f} deg"
    )
    of_five = (
        f"joint 5 at {89 - high[4]:.3f} deg is beyond its limits {90 - high[4]:.1f} to {90 - low[4]:.1f} deg"
    )
    assert line == f"  pose 7: {of_three}; {of_five}"
    (plain,) = lines_on_limits(robot, np.array([7]), q)
    assert f"joint 3 at {low[2] - 5:.3f} deg is beyond its limits {low[2]:.1f} to {high[2]:.1f} deg" in plain
