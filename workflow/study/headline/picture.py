"""The picture of a study's workcell as a PNG, and the pixels at which its parts appear."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from scalar.data.io.atomic import atomic_write, write_json
from study.common.grid import with_overrides


def write_picture(
    scene: str | Path, overrides: Mapping[str, Any], seed: int, picture: str | Path, places: str | Path
) -> None:
    """Write a picture of one case, and where its parts appear.

    Args:
        scene: Config file of the scene.
        overrides: ``{dotted key: value}`` of the case.
        seed: Whose scans are shown.
        picture: PNG.
        places: JSON, ``{name: [x, y]}`` in pixels from the upper left.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    from matplotlib.image import imsave

    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.config import load_config
    from scalar.simulation.render import render_scene
    from scalar.simulation.scene import simulate

    scene = Path(scene)
    config = with_overrides(load_config(scene), overrides)
    found = render_scene(simulate(config | {"seed": seed}, base_dir=scene.parent))
    without_version: Any = {"Software": None}
    with atomic_write(picture) as temporary:
        imsave(temporary, found.image, format="png", metadata=without_version)
    write_json(places, found.places)
