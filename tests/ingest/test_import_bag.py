"""Recorded bags: poses, planes and points of a simulated campaign are recovered, and recordings that give no dataset are refused in a sentence."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import Dataset, read_dataset
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.errors import InvalidInput
from scalar.geometry.se3 import log_so3, transform_from_rotation_vector
from scalar.ingest.bag.messages import read_bag
from scalar.ingest.bag.stops import find_stops
from scalar.ingest.bag.to_dataset import BagSettings, load_workcell, write_recorded_dataset
from tests.ingest.bags import JOINTS, SCANS, write_bag

pytest.importorskip("pybullet")
from scalar.simulation import simulate, write_scene
from tests.simulation.conftest import scene_config

ORDER = "joint_1,joint_2,joint_3,joint_4,joint_5,joint_6"


def run(*arguments):
    """Return status and output of the command line."""
    result = CliRunner().invoke(cli, [str(a) for a in arguments])
    return result.exit_code, result.output


@pytest.fixture(scope="module")
def campaign(tmp_path_factory) -> Dataset:
    """Return a simulated campaign of four poses on each plane."""
    config = scene_config("paper", poses_per_plane=4)
    config["sensor"]["selection"] = "even"
    folder = tmp_path_factory.mktemp("campaign")
    write_scene(simulate(config), folder / "scene")
    return read_dataset(folder / "scene" / "dataset")


@pytest.fixture(scope="module")
def workcell(campaign, tmp_path_factory):
    """Return a dataset.yaml with the joints' names, the rough pose of the scanner and guesses of the planes."""
    folder = tmp_path_factory.mktemp("workcell")
    campaign.write(folder / "d")
    mapping = load_yaml(folder / "d" / "dataset.yaml")
    for joint, name in zip(mapping["robot"]["joints"], ORDER.split(","), strict=True):
        joint["name"] = name
    dump_yaml(mapping, folder / "dataset.yaml")
    return folder / "dataset.yaml"


@pytest.fixture(scope="module")
def bag(campaign, tmp_path_factory):
    """Return a recording of ROS 1."""
    return write_bag(campaign, tmp_path_factory.mktemp("bag") / "campaign.bag", 1, "LaserScan")


@pytest.mark.parametrize(
    "version, kind, within",
    [(1, "LaserScan", 5e-5), (2, "PointCloud2", 1e-6), (2, "LaserScan", 5e-5), ("db3", "LaserScan", 5e-5)],
)
def test_a_campaign_is_recovered(version, kind, within, campaign, workcell, tmp_path):
    """Every pose is found once, in order, with its plane; its points are those on the target, without the box and stray echoes."""
    path = write_bag(campaign, tmp_path / ("c.bag" if version == 1 else "c"), version, kind)
    status, said = run("import-bag", workcell, path, "-o", tmp_path / "d")
    assert status == 0, said
    found = read_dataset(tmp_path / "d")
    assert found.n_poses == campaign.n_poses
    np.testing.assert_allclose(found.q, campaign.q, atol=1e-5)
    assert found.poses["plane"].tolist() == campaign.poses["plane"].tolist()
    np.testing.assert_allclose(np.diff(found.poses["time"]), 2.2, atol=0.11)
    for k in range(found.n_poses):
        mine, true = (d.points[d.starts[k] : d.starts[k + 1]] for d in (found, campaign))
        nearest = np.linalg.norm(mine[:, None] - true[None], axis=2).min(axis=1)
        assert nearest.max() < within
        assert len(mine) > 0.95 * len(true)


def test_two_planes_are_imported_if_there_are_said_to_be_no_more(campaign, workcell, tmp_path):
    """A recording of two planes of three is refused with what to add to dataset.yaml, and imported with that line."""
    two = campaign.subset(campaign.plane_index < 2)
    path = write_bag(two, tmp_path / "c.bag", 1, "LaserScan")
    status, said = run("import-bag", workcell, path, "-o", tmp_path / "d")
    assert status == 3 and "few_planes: true" in said
    assert not (tmp_path / "d").exists()
    dump_yaml({**load_yaml(workcell), "few_planes": True}, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", path, "-o", tmp_path / "d")
    assert status == 0, said
    found = read_dataset(tmp_path / "d")
    assert found.few_planes and found.n_poses == two.n_poses


def test_positions_without_names_are_counted(campaign, workcell, tmp_path):
    """A driver that publishes no names of joints is not said to have published nothing: its positions are taken in their order, here one too many."""
    bag = write_bag(campaign, tmp_path / "c.bag", 1, "LaserScan", named=False)
    mapping = load_yaml(workcell)
    for joint in mapping["robot"]["joints"]:
        del joint["name"]
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 2 and "7 joints" in said and "no messages" not in said


def test_the_order_of_joints_may_be_given(campaign, workcell, bag, tmp_path):
    """Without names in the description a recording with one joint more is refused, unless an option names the joints."""
    mapping = load_yaml(workcell)
    for joint in mapping["robot"]["joints"]:
        del joint["name"]
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 2 and "7 joints" in said and "--joint-names" in said and not (tmp_path / "d").exists()
    status, said = run(
        "import-bag", tmp_path / "dataset.yaml", bag, "--joint-names", ORDER, "-o", tmp_path / "d"
    )
    assert status == 0, said
    np.testing.assert_allclose(read_dataset(tmp_path / "d").q, campaign.q, atol=1e-5)


@pytest.mark.parametrize(
    "options, words",
    [
        (["--scans", "/scaner/profile"], f"did you mean '{SCANS}'?"),
        (["--scans", JOINTS], "is of sensor_msgs/msg/JointState"),
        (["--joints", "/note"], "is of std_msgs/msg/String"),
        (["--joint-names", ORDER.replace("joint_6", "joint_7")], "no joint 'joint_7'"),
        (["--joint-names", "joint_1"], "the robot has 6"),
        (["--still", "0"], "--still"),
    ],
)
def test_wrong_names_are_refused(options, words, workcell, bag, tmp_path):
    """A topic or joint that does not exist gives exit status 2, one line that says what to correct, and no folder."""
    status, said = run("import-bag", workcell, bag, *options, "-o", tmp_path / "d")
    assert status == 2 and words in said, said
    assert len(said.splitlines()) == 1 and not (tmp_path / "d").exists()


def test_a_folder_of_ros_2_may_end_in_bag(campaign, workcell, tmp_path):
    """A folder named ``*.bag`` is read as a recording of ROS 2, not as a file of ROS 1."""
    path = write_bag(campaign, tmp_path / "c", 2, "LaserScan").rename(tmp_path / "good.bag")
    status, said = run("import-bag", workcell, path, "-o", tmp_path / "d")
    assert status == 0, said
    assert read_dataset(tmp_path / "d").n_poses == campaign.n_poses


def test_positions_in_degrees_are_refused_until_they_are_said_to_be(campaign, workcell, tmp_path):
    poses = campaign.poses.copy()
    columns = [f"q{i + 1}" for i in range(6)]
    poses[columns] = np.rad2deg(campaign.q)
    bag = write_bag(replace(campaign, poses=poses), tmp_path / "degrees.bag", 1, "LaserScan")
    status, said = run("import-bag", workcell, bag, "-o", tmp_path / "out")
    assert status == 2 and "say --degrees" in said and not (tmp_path / "out").exists()
    status, said = run("import-bag", workcell, bag, "-o", tmp_path / "out", "--degrees")
    assert status == 0, said
    np.testing.assert_allclose(read_dataset(tmp_path / "out").q, campaign.q, atol=2e-5)


def test_radians_that_are_said_to_be_degrees_are_asked_about(bag, workcell, tmp_path):
    """With --degrees an arm whose positions are radians would hardly move; that is said, and not that the scans lie on one plane."""
    status, said = run("import-bag", workcell, bag, "-o", tmp_path / "out", "--degrees")
    assert status == 2 and "leave out --degrees" in said and len(said.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_damaged_and_missing_recordings_are_refused(workcell, bag, tmp_path):
    """A file cut short, a file that is no bag, an empty folder and a missing file give exit status 2 and one line."""
    raw = bag.read_bytes()
    for k, content in enumerate((raw[: len(raw) // 2], raw[:100], b"", b"not a bag at all\n" * 50)):
        path = tmp_path / f"{k}.bag"
        path.write_bytes(content)
        status, said = run("import-bag", workcell, path, "-o", tmp_path / "d")
        assert status == 2 and "cannot be read as a ROS bag" in said, said
        assert len(said.splitlines()) == 1
    (tmp_path / "empty").mkdir()
    assert run("import-bag", workcell, tmp_path / "empty", "-o", tmp_path / "d")[0] == 2
    assert "no such file" in run("import-bag", workcell, tmp_path / "x.bag", "-o", tmp_path / "d")[1]
    assert not (tmp_path / "d").exists()


def test_scans_in_millimetres_are_refused(bag, workcell, tmp_path):
    """Messages of ROS have metres; nothing is searched for in scans that are a thousand times as large."""
    recording = read_bag(bag)
    large = replace(recording, scans=[1000.0 * points for points in recording.scans])
    with pytest.raises(InvalidInput, match="in millimetres"):
        write_recorded_dataset(
            large, load_workcell(workcell), BagSettings((), 5e-4, 0.2, 0.3), tmp_path / "dataset"
        )


def test_a_recording_of_an_arm_that_never_stops_is_refused(campaign, workcell, tmp_path):
    """A valid recording that gives no pose ends with exit status 3."""
    path = write_bag(campaign, tmp_path / "c.bag", 1, "LaserScan", moving=True)
    status, said = run("import-bag", workcell, path, "-o", tmp_path / "d")
    assert status == 3 and "never stands still" in said and not (tmp_path / "d").exists()


def test_a_workcell_without_a_usable_scanner_pose_is_refused(workcell, bag, tmp_path):
    """Without a nominal pose of the scanner the exit status is 2; with one far off, so that no scan is near a plane, it is 3."""
    mapping = load_yaml(workcell)
    pose = mapping["sensor"].pop("nominal_pose")
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 2 and "sensor.nominal_pose: missing" in said
    mapping["sensor"]["nominal_pose"] = pose | {"translation": [2.0, 2.0, 2.0]}
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 3 and "sensor.nominal_pose" in said and not (tmp_path / "d").exists()


def test_a_wrong_order_of_joints_is_refused_with_the_right_one(workcell, bag, tmp_path):
    """With two joints exchanged the exit status is 3, and the message has the most frequent reason and the order that puts scans on planes."""
    wrong = ORDER.split(",")
    wrong[1], wrong[2] = wrong[2], wrong[1]
    status, said = run("import-bag", workcell, bag, "--joint-names", ",".join(wrong), "-o", tmp_path / "d")
    assert status == 3 and not (tmp_path / "d").exists()
    lines = said.splitlines()
    assert "stops became poses" in lines[0] and "on no plane" in lines[0] and "--joint-names" in lines[0]
    assert f"--joint-names {ORDER}" in lines[1]


@pytest.mark.parametrize("joint", [2, 3])
def test_a_joint_that_counts_the_other_way_is_told_with_its_remedy(joint, workcell, bag, tmp_path):
    """A table whose joint counts the other way: it is said, and with what it says to change the whole campaign comes back."""
    mapping = load_yaml(workcell)
    joints = mapping["robot"]["joints"]
    assert mapping["robot"]["convention"] == "modified-dh"

    def count_otherwise():
        joints[joint - 1]["d"] *= -1.0
        joints[joint - 1]["theta"] *= -1.0
        joints[joint - 1]["alpha"] += np.pi
        joints[joint]["alpha"] -= np.pi

    count_otherwise()
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 3 and "do not fit the set-up as described" in said
    told = said.splitlines()[1]
    assert f"12 of 12 scans would lie on a plane with joint {joint} (joint_{joint}) counted" in told
    assert f"signs of d and theta of joint {joint}, add 3.141593 to alpha of joint {joint}" in told
    assert f"subtract it from alpha of joint {joint + 1}" in told
    count_otherwise()
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 0, said


def test_wrong_axes_of_the_scanner_are_refused_with_the_right_ones(workcell, bag, tmp_path):
    """If the nominal pose is turned by half a turn about x, the message says that z of the scan is reversed, and nothing is written."""
    mapping = load_yaml(workcell)
    pose = mapping["sensor"]["nominal_pose"]
    T = transform_from_rotation_vector(pose["translation"], pose["rotation_vector"])
    turned = T @ np.diag([1.0, -1.0, -1.0, 1.0])
    pose["rotation_vector"] = log_so3(turned[None, :3, :3])[0].tolist()
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 3 and not (tmp_path / "d").exists(), said
    assert "z of the scan" in said and "sensor.nominal_pose" in said


def test_a_reversed_x_axis_is_refused_though_every_scan_is_near_a_plane(workcell, bag, tmp_path):
    """If the nominal pose is turned by half a turn about z, scans are as near to the planes as before, with other slopes; x is named as reversed."""
    mapping = load_yaml(workcell)
    pose = mapping["sensor"]["nominal_pose"]
    T = transform_from_rotation_vector(pose["translation"], pose["rotation_vector"])
    turned = T @ np.diag([-1.0, -1.0, 1.0, 1.0])
    pose["rotation_vector"] = log_so3(turned[None, :3, :3])[0].tolist()
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 3 and not (tmp_path / "d").exists(), said
    assert "12 of 12 scans would lie on a plane with x of the scan reversed" in said
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "--accept-losses", "-o", tmp_path / "d")
    assert status == 0 and (tmp_path / "d").exists(), said


def test_losses_may_be_accepted_and_are_counted(workcell, campaign, tmp_path):
    """If most stops have no scan, the exit status is 3, and the message names the option with which the others are written."""
    path = write_bag(campaign, tmp_path / "c.bag", 1, "LaserScan", blind=2)
    status, said = run("import-bag", workcell, path, "-o", tmp_path / "d")
    assert status == 3 and "without a scan" in said and "--accept-losses" in said
    assert not (tmp_path / "d").exists()
    status, said = run("import-bag", workcell, path, "--accept-losses", "-o", tmp_path / "d")
    assert status == 0 and "without a scan" in said
    assert read_dataset(tmp_path / "d").n_poses == campaign.n_poses // 3


def test_stops_are_those_without_motion():
    """Every stop that lasts long enough is found once, and begins when the arm has settled; shorter ones are not found."""
    rng = np.random.default_rng(2)
    times, q, stops = [0.0], [0.0], []
    for _k in range(30):
        stop = float(rng.choice([0.1, 0.9]))
        for duration, speed in ((0.5, rng.choice([-1, 1]) * rng.uniform(0.2, 1.0)), (stop, 0.0)):
            start = times[-1]
            steps = round(duration / 0.01)
            times += [start + 0.01 * (i + 1) for i in range(steps)]
            q += [q[-1] + speed * 0.01 * (i + 1) for i in range(steps)]
            if speed == 0.0 and stop > 0.5:
                stops.append((start, times[-1], q[-1]))
    positions = np.array(q)[:, None] + 1e-5 * rng.uniform(-1, 1, (len(q), 1))
    found = find_stops(np.array(times), positions)
    assert len(found) == len(stops)
    for found_stop, (start, end, value) in zip(found, stops, strict=True):
        assert start + 0.1 < found_stop.start < found_stop.end < end + 0.02
        assert abs(found_stop.q[0] - value) < 2e-4
