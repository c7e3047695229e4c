"""An effect that a sensor cannot show is refused by name on the command line, before anything is fitted."""

import pytest

from scalar.effects.command_line import parse_effects
from scalar.errors import InvalidInput
from tests.random_scene import make_scene


@pytest.mark.parametrize("kind", ["tracker", "probe"])
@pytest.mark.parametrize("name", ["range_scale", "range_offset", "range_distortion"])
def test_an_error_of_the_range_needs_a_sensor_that_measures_ranges(kind: str, name: str) -> None:
    """A tracker and a probe measure no range along a ray, so the effect is refused with its name and the kind of sensor."""
    dataset = make_scene(kind=kind, poses_per_plane=4).dataset
    with pytest.raises(
        InvalidInput, match=rf"{name}: this effect needs a sensor that measures ranges.*{kind}"
    ):
        parse_effects(name, dataset)


@pytest.mark.parametrize("name", ["plane_bow", "plane_moved:floor:3"])
def test_an_effect_of_a_plane_needs_planes(name: str) -> None:
    """A tracker has no target planes, so an effect of one is refused, and not silently left out."""
    dataset = make_scene(kind="tracker", poses_per_plane=4).dataset
    with pytest.raises(InvalidInput, match="needs target planes"):
        parse_effects(name, dataset)
