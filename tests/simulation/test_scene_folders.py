"""The folders of a scene: a dataset that reveals nothing of the truth, and a truth outside it."""

import json

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from scalar.data.dataset import read_dataset
from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import InvalidInput
from scalar.simulation import simulate, write_scene
from tests.simulation.conftest import scene_config
from tests.simulation.geometry import sensor_frames
from tests.simulation.noise_checks import ALPHA


def test_the_dataset_reads_back_and_reveals_nothing(tmp_path):
    """The folder is a valid dataset, and no number that was injected stands in any of its files."""
    config = scene_config("ur10e")
    config["true_robot_errors"] |= {"beta_std_deg": 0.1}
    scene = simulate(config)
    write_scene(scene, tmp_path)
    assert read_dataset(tmp_path / "dataset").n_poses == len(scene.q)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["dataset", "truth"]
    text = "".join(path.read_text() for path in (tmp_path / "dataset").iterdir())
    truth = json.loads((tmp_path / "truth/truth.json").read_text())
    injected = [value for values in truth["parameters"].values() for value in values]
    injected += [x for normal in truth["planes"]["normals"] for x in normal] + truth["planes"]["distances"]
    injected = [value for value in injected if value not in (0.0, 1.0)]  # a floor's normal, say
    assert len(injected) > 36
    assert not [value for value in injected if repr(abs(value))[:10] in text]
    assert "seed" not in load_yaml(tmp_path / "dataset/dataset.yaml")


def test_truth_has_the_agreed_form(paper):
    """truth.json holds the agreed keys; truth_poses the agreed columns, and the frames that SciPy gives."""
    assert set(paper.truth["parameters"]) == {"a", "alpha", "d", "theta", "beta", "t", "r"}
    assert {"robot", "planes", "effects", "noise_m", "note", "seed"} <= set(paper.truth)
    table = paper.truth_poses
    assert list(table) == ["pose", *(f"q{i + 1}" for i in range(6)), "x", "y", "z", "rx", "ry", "rz"]
    q = table[[f"q{i + 1}" for i in range(6)]].to_numpy()
    limits = paper.workcell.arm.limits
    assert stats.kstest(((q - limits[:, 0]) / np.ptp(limits, axis=1)).ravel(), "uniform").pvalue > ALPHA
    T = sensor_frames(paper.workcell.arm, q)
    np.testing.assert_allclose(table[["x", "y", "z"]].to_numpy(), T[:, :3, 3], atol=1e-12, rtol=0)
    vectors = table[["rx", "ry", "rz"]].to_numpy()
    np.testing.assert_allclose(Rotation.from_rotvec(vectors).as_matrix(), T[:, :3, :3], atol=1e-12, rtol=0)


def test_nothing_of_someone_elses_is_overwritten(tmp_path, paper):
    """A folder that is no dataset or truth of ours stays as it is."""
    (tmp_path / "truth").mkdir()
    (tmp_path / "truth" / "thesis.txt").write_text("mine")
    with pytest.raises(InvalidInput):
        write_scene(paper, tmp_path)
    assert [path.name for path in tmp_path.rglob("*")] == ["truth", "thesis.txt"]
