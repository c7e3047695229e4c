"""Complete the config of a scene, with the keys that a study replaces; and find its walls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot
from pathlib import Path
from typing import Any

from study.common.grid import with_overrides

UPRIGHT = 0.5
"""A target plane is a wall if the vertical component of its unit normal is smaller than this."""


def is_wall(plane: Mapping[str, Any]) -> bool:
    """Return whether a target plane of a scene's config is a wall, upright or leaning; else it is level, as a floor is."""
    return abs(plane["normal"][2]) < UPRIGHT * hypot(*plane["normal"])


def scene_config(scene: Path, overrides: Sequence[Mapping[str, Any]], **entries: Any) -> dict[str, Any]:
    """Return the complete config of a scene.

    Args:
        scene: Config file of the scene.
        overrides: Mappings ``{dotted key: value}`` of keys to replace, applied one after the other.
        entries: Keys of the config's top level that are replaced after these.

    Raises:
        InvalidInput: The scene, an override or an entry is at fault.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.config import complete_config, load_config

    config = load_config(scene)
    for keys in overrides:
        config = with_overrides(config, keys)
    return complete_config(config | entries, base_dir=scene.parent)
