"""The comparison with published figures repeats the authors' split, and predicts with their parameters what their equation says."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation
from study.common.tables import read_table
from study.measured.originals import read_originals

from benchmarks.diagnosis import published
from benchmarks.diagnosis.published import PUBLISHED, compare, first_poses, iiwa_positions, split, summary
from scalar.geometry.robot import Robot
from scalar.units import DEG, MM
from tests.random_scene import make_scene

ROOT = Path(__file__).parents[2]
RNG = np.random.default_rng(7)
Q, TORQUE = RNG.uniform(-2, 2, (20, 7)), RNG.uniform(-50, 50, (20, 7))
SMALL = 1e-2 * RNG.standard_normal(40)


def table_of_the_iiwa():
    """Return the robot of configs/measured/iiwa7_tracker.yaml."""
    text = (ROOT / "configs/measured/iiwa7_tracker.yaml").read_text(encoding="utf-8")
    robot = yaml.safe_load(text)["dataset"]["robot"]
    joints = [
        {"a": j["a"] * MM, "alpha": j["alpha"] * DEG, "d": j["d"] * MM, "theta": j["theta"] * DEG}
        for j in robot["joints"]
    ]
    return Robot.from_mapping(robot | {"joints": joints})


def test_the_authors_model_is_that_of_the_mapping():
    """With no correction but frames, the authors' model places the target where the robot of our mapping has it."""
    parameters = np.r_[np.zeros(28), SMALL[28:]]
    expected = table_of_the_iiwa().flange(Q)
    last = Rotation.from_euler("XYZ", parameters[31:34])
    placed = (expected @ np.r_[parameters[34:37], 1.0])[:, :3]
    np.testing.assert_allclose(
        iiwa_positions(Q, TORQUE, parameters), last.apply(placed) + parameters[37:], atol=1e-12
    )


def test_a_compliance_turns_its_joint_by_its_torque():
    """A compliance by the torque is a change of the angle by compliance times torque, and an offset of a zero one by the offset."""
    yielding = SMALL.copy()
    yielding[21:28] *= 1e-3
    rigid = yielding.copy()
    rigid[21:28] = rigid[:7] = 0.0
    np.testing.assert_allclose(
        iiwa_positions(Q, TORQUE, yielding),
        iiwa_positions(Q + yielding[:7] + yielding[21:28] * TORQUE, TORQUE, rigid),
        atol=1e-12,
    )


@pytest.mark.parametrize("left_out", [0, 1, 20])
def test_the_first_four_fifths_are_learned_from(left_out):
    """Every pose that is not left out is either learned from or not, and the former come first, four fifths of all."""
    learned, rest = first_poses(304, left_out)
    assert not np.any(learned & rest) and not np.any((learned | rest)[:left_out])
    assert np.all((learned | rest)[left_out:]) and np.flatnonzero(learned).max() < np.flatnonzero(rest).min()
    assert abs(learned.sum() - 0.8 * (304 - left_out)) <= 0.5


def test_a_summary_is_of_distances():
    """Mean, standard deviation and maximum are in mm."""
    found = summary(np.array([1.0, 2.0, 3.0]) * MM)
    assert found == pytest.approx({"mean_mm": 2.0, "std_mm": 1.0, "max_mm": 3.0})


def test_a_grid_is_learned_from_and_the_poses_judge(monkeypatch):
    """The grid of a Motoman is learned from, its other campaign judges, and an arm without effects is predicted to the noise."""
    scene = make_scene(kind="tracker", seed=3, poses_per_plane=40, noise=2e-5)
    sets = {"arm_grid": scene.dataset, "arm_poses": scene.dataset.subset(np.arange(120) % 2 == 0)}
    monkeypatch.setattr(published, "read_dataset", lambda folder: sets[folder.name])
    wanted = split(Path("sets"), "arm_poses")
    assert (wanted.learned.n_poses, wanted.judged["unseen"].n_poses) == (120, 60)
    found = compare(wanted, None, {})
    assert found["learned_from"] == 120 and found["unseen"]["poses"] == 60
    assert found["unseen"]["diagnosis"]["mean_mm"] < 0.05


def test_every_published_value_is_of_a_listed_set():
    """The sets of the table are listed with their original files, of the same repository and commit, and each row says where its value stands."""
    table = read_table(PUBLISHED)
    listed = {
        **read_originals(ROOT / "workflow/resources/measured.csv"),
        **read_originals(ROOT / "workflow/resources/measured_by_hand.csv"),
    }
    for row in table.itertuples():
        assert {(o.repository, o.commit) for o in listed[row.set]} == {(row.repository, row.commit)}
        assert row.place and row.judged in ("fit", "unseen")
        assert 0 < row.position_std_mm and 0 < row.position_mean_mm < row.position_max_mm
    assert not table.duplicated(["set", "method"]).any()
