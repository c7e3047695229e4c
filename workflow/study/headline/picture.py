"""Draw the simulated workcell of a case as a PNG, and state the pixels at which its parts appear."""

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
        seed: Seed of the scene whose scans are shown.
        picture: The PNG file to write.
        places: The JSON file to write, ``{name of a part: [x, y]}`` in pixels from the upper left corner.

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
