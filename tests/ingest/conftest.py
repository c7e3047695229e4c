"""What tests of recorded bags share: a simulated campaign, its description, and a recording of it."""

import pytest

from scalar.data.dataset import Dataset, read_dataset
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from tests.ingest.bags import ORDER, write_bag


@pytest.fixture(scope="module")
def campaign(tmp_path_factory) -> Dataset:
    """Return a simulated campaign of four poses on each plane; tests that ask for it are skipped without pybullet."""
    pytest.importorskip("pybullet")
    from scalar.simulation import simulate, write_scene
    from tests.simulation.conftest import scene_config

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
