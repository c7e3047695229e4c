"""A plane that is declared known where the data do not have it is refused or doubted; one that is where it is declared is not mentioned."""

from __future__ import annotations

from dataclasses import replace

import pytest

from scalar.data.dataset import Dataset
from scalar.diagnosis import diagnose
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.geometry.robot import Tolerance
from scalar.geometry.se3 import exp_so3
from scalar.units import DEG, MM
from tests.random_scene import make_scene

KNOWN_TO = {"distance_std": 1 * MM, "normal_std": 1e-3}


@pytest.fixture(scope="module")
def known() -> Dataset:
    """Return scans of three planes, the second of which is known where it truly is, by an arm of known tolerance."""
    data = make_scene(
        "vs060",
        poses_per_plane=20,
        points_per_scan=12,
        noise=1e-4,
        seed=5,
        length_error=1e-4,
        angle_error=1e-3,
    ).dataset
    floor, wall, other = data.planes
    robot = replace(data.robot, tolerance=Tolerance(0.1 * MM, 1e-3))
    return replace(data, robot=robot, planes=(floor, replace(wall, **KNOWN_TO), other))


def declared(dataset: Dataset, shift: float = 0.0, tilt: float = 0.0) -> Dataset:
    """Return the dataset with its known plane declared ``shift`` [m] and ``tilt`` [rad] from where it is."""
    floor, wall, other = dataset.planes
    normal = exp_so3([0.0, 0.0, tilt]) @ wall.normal
    return replace(
        dataset, planes=(floor, replace(wall, distance=wall.distance + shift, normal=normal), other)
    )


def doubts(dataset: Dataset) -> list[str]:
    """Return what a calibration says of known planes."""
    return [s["sentence"] for s in calibrate(dataset).summary["setup"] if s["what"] == "known_plane"]


@pytest.mark.parametrize("explains", [calibrate, pytest.param(diagnose, marks=pytest.mark.slow)])
def test_a_plane_declared_far_from_where_it_is_is_refused(known, explains):
    """The refusal names the plane, what it is declared to, where the data have it, and the way out; it stands alone."""
    with pytest.raises(InvalidInput) as refused:
        explains(declared(known, shift=200 * MM))
    (fault,) = refused.value.faults
    assert fault.column == f"planes.{known.planes[1].name}.known"
    assert "declared known to 1 mm" in fault.message and "remove known" in fault.message
    away = float(fault.message.split(" mm away")[0].rsplit(" ", 1)[1])
    assert away == pytest.approx(200, abs=2)


def test_a_normal_declared_degrees_away_is_refused(known):
    """A plane that is turned says so, by its normal."""
    with pytest.raises(InvalidInput, match="the normal of plane wall_x is declared known to"):
        calibrate(declared(known, tilt=5 * DEG))


def test_a_plane_declared_a_few_millimetres_away_is_doubted(known):
    """It is not impossible that arm or sensor lack something that the model does not have, so it is calibrated and said."""
    (sentence,) = doubts(declared(known, shift=9 * MM))
    assert "plane wall_x is declared known to 1 mm" in sentence


def test_a_plane_that_moves_the_base_is_named_with_its_length(known):
    """Where no tolerance is stated, the first axis is free in the base frame, and follows a plane: either may be wrong, and both are named."""
    free = replace(declared(known, shift=200 * MM), robot=replace(known.robot, tolerance=None))
    (said,) = (s["sentence"] for s in calibrate(free).summary["setup"] if s["what"] == "robot")
    assert said.startswith("a_1 comes out 200 mm") and "is wall_x not where it is declared known" in said


def test_a_plane_where_it_is_declared_is_not_mentioned(known):
    """Nor is a plane that errs within its stated standard deviation, however large, or one that is only guessed."""
    assert not doubts(known)
    floor, wall, other = declared(known, shift=50 * MM).planes
    assert not doubts(replace(known, planes=(floor, replace(wall, distance_std=50 * MM), other)))
    guessed = replace(wall, distance_std=None, normal_std=None)
    assert not doubts(replace(known, planes=(floor, guessed, other)))
