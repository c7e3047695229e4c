"""Scenes that several tests look at, simulated once."""

import copy
from pathlib import Path
from typing import Any

import pytest

from scalar.simulation import SimulatedScene, load_config, simulate

CONFIGS = Path(__file__).parents[2] / "configs"
SCENES = ("paper", "paper_tilted", "ur10e", "panda", "puma560")
POSES_PER_PLANE = 12


def scene_config(name: str, **changes: Any) -> dict[str, Any]:
    """Return the config of a committed scene, small, with top-level keys replaced."""
    config = load_config(CONFIGS / "scenes" / f"{name}.yaml")
    config["truth_poses"] = 100
    config["poses_per_plane"] = POSES_PER_PLANE
    return config | copy.deepcopy(changes)


@pytest.fixture(scope="session", params=SCENES)
def scene(request: pytest.FixtureRequest) -> SimulatedScene:
    """Return each committed scene in turn, with a dozen poses a plane."""
    return simulate(scene_config(request.param))


@pytest.fixture(scope="session")
def paper() -> SimulatedScene:
    """Return the paper's scene without noise, with its points spread evenly."""
    config = scene_config("paper", noise={})
    config["sensor"]["selection"] = "even"
    return simulate(config)
