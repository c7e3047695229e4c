"""`scalar init`: folders that say what is missing, read back once they are filled, and never take the place of anything."""

import pytest
from click.testing import Result

from scalar.data.dataset import read_dataset
from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import printable
from scalar.geometry.robot import Robot
from scalar.robots import arm_names, read_arm
from tests import small_datasets
from tests.cli.running import begun, run

KINDS = ("line-laser", "probe", "tracker")


def refused(result: Result, *words: str) -> None:
    """Check that a command ended with status 2 and a line on stderr that has the words."""
    assert result.exit_code == 2 and "Traceback" not in result.output
    (line,) = result.stderr.splitlines()
    assert line.startswith("scalar: ") and all(word in line for word in words), line


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_missing_is_said_and_nothing_else(kind, tmp_path):
    """An empty folder of each kind lacks its rows and what only the user knows; its robot and format have no fault."""
    folder = begun(tmp_path / "cell", "--robot", "ur5e", sensor=kind)
    result = run("validate", folder)
    assert result.exit_code == 2
    missing = {"poses.csv"}
    missing |= {"planes"} if kind != "tracker" else {"points.csv"}
    missing |= {"nominal_pose"} if kind != "line-laser" else {"scans.csv"}
    lines = result.stderr.splitlines()
    assert len(lines) == len(missing)
    assert all(any(word in line for line in lines) for word in missing)


@pytest.mark.parametrize("kind", KINDS)
def test_the_pose_of_the_sensor_is_never_called_optional(kind, tmp_path):
    """The file says which commands need the sensor's pose, and those commands do need it."""
    text = (begun(tmp_path / "cell", "--robot", "ur5e", sensor=kind) / "dataset.yaml").read_text()
    (line,) = [line for line in text.splitlines() if "nominal_pose" in line]
    assert "needed" in line and "optional" not in line
    if kind == "line-laser":
        assert "scalar plan" in line and "scalar import-bag" in line


@pytest.mark.parametrize("kind", KINDS)
def test_a_folder_that_is_filled_is_a_dataset(kind, tmp_path):
    """If the comments before needed keys are removed and rows stand under the headers, the folder is read without a fault."""
    folder = begun(tmp_path / "cell", "--robot", "abb_irb120", sensor=kind)
    text = (folder / "dataset.yaml").read_text()
    text = text.replace("  # nominal_pose:", "  nominal_pose:")
    text = text.replace("planes: []", "planes:").replace("\n#  - {name", "\n  - {name")
    (folder / "dataset.yaml").write_text(text)
    for name, table in small_datasets.tables(kind).items():
        if table is not None:
            path = folder / f"{name}.csv"
            wanted = path.read_text().strip().split(",")
            table.rename(columns=str)[wanted].to_csv(path, index=False)
    dataset = read_dataset(folder)
    assert dataset.sensor.kind == kind and dataset.robot.name == "abb_irb120"


@pytest.mark.parametrize("name", arm_names())
def test_the_robot_of_the_folder_is_that_of_the_library(name, tmp_path):
    """dataset.yaml has the library's numbers to the last digit, for every arm."""
    folder = begun(tmp_path / "cell", "--robot", name)
    written = Robot.from_mapping(load_yaml(folder / "dataset.yaml")["robot"])
    assert written.to_mapping() == Robot.from_mapping(read_arm(name).mapping).to_mapping()


def test_an_unverified_arm_is_called_so(tmp_path):
    """The terminal, the list, dataset.yaml and whatever shows the dataset's source, as `validate` does, say that the sources of the arm differ."""
    name = next(name for name in arm_names() if not read_arm(name).verified)
    result = run("init", tmp_path / "cell", "--robot", name, "--sensor", "tracker")
    assert "UNVERIFIED" in result.stdout
    assert "UNVERIFIED" in load_yaml(tmp_path / "cell" / "dataset.yaml")["source"]
    assert any(name in line and "UNVERIFIED" in line for line in run("init", "--list").stdout.splitlines())


def test_the_list_has_every_arm():
    """The list has a line for each arm, and one that counts them."""
    lines = run("init", "--list").stdout.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == arm_names()


def test_a_wrong_robot_or_sensor_is_refused(tmp_path):
    """A wrong name, no robot or two, and a missing sensor give one line each, and no folder."""
    folder = tmp_path / "cell"
    refused(run("init", folder, "--robot", "ur5ee", "--sensor", "probe"), "did you mean", "ur5e")
    refused(run("init", folder, "--sensor", "probe"), "--robot", "--urdf", "--dh")
    refused(run("init", folder, "--robot", "ur5e", "--dh", "t.csv", "--sensor", "probe"), "one of")
    refused(run("init", folder, "--robot", "ur5e"), "--sensor", "missing", *KINDS)
    refused(run("init", folder, "--robot", "ur5e", "--sensor", "camera"), "camera", *KINDS)
    for written, meant in (
        ("laser-tracker", "tracker"),
        ("Line_Laser", "line-laser"),
        ("touch probe", "probe"),
    ):
        answer = run("init", folder, "--robot", "ur5e", "--sensor", written)
        refused(answer, f"did you mean {meant}?", *KINDS)
    refused(run("init", folder, "--dh", "t.csv", "--sensor", "probe"), "--convention")
    refused(
        run("init", folder, "--dh", "a.urdf", "--convention", "modified-dh", "--sensor", "probe"), "--urdf"
    )
    refused(run("init", folder, "--robot", "ur5e", "--tip", "x", "--sensor", "probe"), "--urdf")
    refused(run("init", folder, "--urdf", tmp_path / "none.urdf", "--sensor", "probe"), "none.urdf")
    assert not folder.exists()


def test_nothing_is_overwritten(tmp_path):
    """A folder that holds anything stays as it is, even one of an earlier `init`."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("kept")
    refused(run("init", tmp_path / "mine", "--robot", "ur5e", "--sensor", "probe"), "mine", "already there")
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["notes.txt"]
    folder = begun(tmp_path / "cell", "--robot", "ur5e")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = run("init", folder, "--robot", "ur3e", "--sensor", "probe")
    refused(result, "already there")
    assert "remove" not in result.stderr  # it may hold measurements
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("name", ["a: b # c", "1e5", '"q', "x\ny", "del\x7f", "é😀", "\udcff"])
def test_any_name_of_a_folder_is_written_so_that_it_is_read(name, tmp_path):
    """The folder's name becomes the dataset's; unprintable characters are written as escapes, and dataset.yaml stays valid YAML."""
    begun(tmp_path / name, "--robot", "ur5e")
    assert load_yaml(tmp_path / name / "dataset.yaml")["name"] == printable(name)


def test_a_file_name_does_not_break_out_of_its_comment(tmp_path):
    """A line end in the name of a table does not end the comment in which dataset.yaml quotes it."""
    table = tmp_path / "arm\nsensor: {}.csv"
    table.write_text("a_mm,alpha_deg,d_mm,theta_deg\n0,0,0,0\n")
    folder = begun(tmp_path / "cell", "--dh", table, "--convention", "standard-dh")
    assert load_yaml(folder / "dataset.yaml")["sensor"] == {"kind": "tracker"}


def test_the_readme_states_units_and_counting_of_the_joints(tmp_path):
    """README.txt says that a joint of a FANUC is not counted as its controller shows it, and that a joint that slides is in metres."""
    readme = (begun(tmp_path / "fanuc", "--robot", "fanuc_lrmate200id") / "README.txt").read_text()
    assert "q3 = J3 + J2" in readme and "travel in metres" not in readme
    table = tmp_path / "rail.csv"
    table.write_text(
        "a_mm,alpha_deg,d_mm,theta_deg,type\n0,0,0,0,prismatic\n0,90,400,0,revolute\n300,0,0,0,revolute\n"
    )
    readme = (
        begun(tmp_path / "rail", "--dh", table, "--convention", "modified-dh") / "README.txt"
    ).read_text()
    assert "q1: the travel in metres" in readme and "q2: " not in readme
