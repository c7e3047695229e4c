"""Recorded bags: poses, planes and points of a simulated campaign are recovered, and recordings that give no dataset are refused in a sentence."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import read_dataset
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.errors import InvalidInput
from scalar.ingest.bag.messages import read_bag
from scalar.ingest.bag.stops import find_stops
from scalar.ingest.bag.to_dataset import BagSettings, load_workcell, write_recorded_dataset
from tests.ingest.bags import JOINTS, ORDER, SCANS, run, write_bag


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
