"""The robots of configs/robots: the content of their files, and which parameters the data of each leave undetermined."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import yaml

ROBOT_CONFIGS = Path(__file__).parents[1] / "configs" / "robots"

PUBLISHED_FIXED = ("d_6", "theta_6", "d_2", "a_1", "alpha_1", "theta_1", "d_1")
"""The parameters that the original paper fixed."""
FIXED_WITH_PLANES = {
    "vs060": PUBLISHED_FIXED,
    "puma560": PUBLISHED_FIXED,
    "ur10e": (*PUBLISHED_FIXED, "d_3"),
    "panda": ("d_7", "theta_7", "a_1", "alpha_1", "theta_1", "d_1"),
}
"""By robot, the parameters that data on planes do not determine. Nominal models of the tests have their true values, so that errors
before a calibration mean something.
"""
FIXED_WITH_PROBE = {"vs060": "a_3", "puma560": "a_3", "ur10e": "a_3", "panda": "d_5"}
"""By robot, the one length that is fixed as well where a probe measures: contacts do not determine the scale."""


def robot_mapping(name: str) -> dict[str, Any]:
    """Return the content of ``configs/robots/<name>.yaml``."""
    return dict(_robot_mapping(name))


@functools.cache
def _robot_mapping(name: str) -> dict[str, Any]:
    return yaml.safe_load((ROBOT_CONFIGS / f"{name}.yaml").read_text(encoding="utf-8"))
