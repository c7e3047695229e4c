"""The content of dataset.yaml of a simulated scene."""

from collections.abc import Mapping
from typing import Any

from scalar.data.formats import DATASET_FORMAT
from scalar.simulation.arm import arm_mapping, pose_mapping
from scalar.simulation.declared import draw_errors, guess_plane
from scalar.simulation.noise import Noise
from scalar.simulation.plan import Workcell
from scalar.simulation.streams import INITIAL_MODEL, PLANE_GUESS, stream


def dataset_mapping(config: Mapping[str, Any], workcell: Workcell, noise: Noise) -> dict[str, Any]:
    """Return the content of dataset.yaml: what a user would know, and nothing else of the truth."""
    seed = config["seed"]
    declared = workcell.nominal
    if "initial_model" in config:
        errors = draw_errors(config["initial_model"], declared.n, stream(seed, INITIAL_MODEL))
        declared = declared.shifted(errors)
    sensor: dict[str, Any] = {"kind": "line-laser"}
    if config["sensor"]["nominal"] == "given":
        sensor["nominal_pose"] = pose_mapping(declared.T_flange_sensor)
    if config["sensor"]["state_noise"] and noise.range_std > 0:
        sensor["noise"] = noise.range_std
    sensor["error_axis"] = workcell.scanner.error_axis
    return {
        "format": DATASET_FORMAT,
        "name": config["name"],
        "source": "simulated with pybullet by scalar",
        "robot": arm_mapping(declared),
        "sensor": sensor,
        "planes": [
            guess_plane(target_plane, config["plane_guess"], stream(seed, PLANE_GUESS, k))
            for k, target_plane in enumerate(workcell.target_planes)
        ],
    }
