"""Planes whose declared places a fit satisfies by warping arm or scanner are doubted, or refused; right declarations are not mentioned."""

from dataclasses import replace

import pytest

from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.planes.wrongly_known_planes import with_and_without
from scalar.units import MM
from tests.random_scene import make_scene

EXACTLY = {"distance_std": 1e-5, "normal_std": 1e-4}


def scene(sensor, seed=5):
    """Return scans or contacts of three planes of an arm with errors of tenths of a millimetre, the planes where they are stated."""
    return make_scene(
        "vs060",
        sensor,
        poses_per_plane=30,
        points_per_scan=12,
        noise=5e-5,
        seed=seed,
        length_error=3e-4,
        angle_error=1e-3,
    ).dataset


def known(dataset, *shifts):
    """Return the dataset with each plane declared known, its distance wrong by so much [m]."""
    planes = tuple(
        replace(plane, distance=plane.distance + shift, **EXACTLY)
        for plane, shift in zip(dataset.planes, shifts, strict=True)
    )
    return replace(dataset, planes=planes)


def doubts(dataset):
    """Return what a calibration says of known planes."""
    return [s["sentence"] for s in calibrate(dataset).summary["setup"] if s["what"] == "known_plane"]


@pytest.mark.parametrize("sensor", ["line-laser", "probe"])
@pytest.mark.parametrize("seed", [5, 6])
def test_right_declarations_are_not_mentioned(sensor, seed):
    assert not doubts(known(scene(sensor, seed), 0.0, 0.0, 0.0))


def test_planes_that_a_scanner_has_nearer_to_one_another_are_refused():
    """The scans know the distances between the planes, so that the residual is clearly smaller without the declarations."""
    dataset = known(scene("line-laser"), 4 * MM, 4 * MM, 4 * MM)
    with pytest.raises(
        InvalidInput, match=r"without the places of planes .* that are declared known, the residual is"
    ):
        calibrate(dataset)


def test_the_radius_of_a_ball_that_was_left_in_is_doubted():
    """A probe has no lengths of its own: the arm takes up what is wrong, and its lengths are nearer to the table without the declarations."""
    (sentence,) = doubts(known(scene("probe"), 4 * MM, 4 * MM, 4 * MM))
    assert "a ball of some radius" in sentence and "from the table of joints" in sentence


def test_there_is_nothing_to_compare_without_known_planes():
    dataset = scene("line-laser")
    assert with_and_without(dataset, calibrate(dataset).model) is None
