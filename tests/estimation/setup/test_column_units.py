"""One column of the measured points in another unit than the others is named, with the unit and the key of the mapping."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.estimation.setup.tables.column_units import column_units
from tests.random_scene import make_scene
from tests.tracked_targets import drawn_arm


@pytest.fixture(scope="module")
def scanned() -> Dataset:
    """Return sixty scans of three planes."""
    return make_scene("vs060", poses_per_plane=20, noise=1e-4, seed=5).dataset


@pytest.mark.parametrize(
    ("factors", "says"),
    [
        ((1000.0, 1.0), "the column x is in millimetres, and z in metres"),
        ((1.0, 1 / 0.0254), "the column z is in inches, and x in metres"),
        ((1.0, 0.001), "the column z is 1000 times too small compared with x, as metres are"),
        (
            (0.1, 1.0),
            "the column x is 10 times too small compared with z, as centimetres are that were taken",
        ),
        ((1.0, 25.4), "the column z is 25.4 times too large compared with x, as millimetres are that were"),
    ],
)
def test_a_column_in_another_unit_is_named(scanned, factors, says):
    """Calibration is refused with the column and its unit, and with nothing else that would explain the data."""
    with pytest.raises(WrongSetup) as refused:
        calibrate(replace(scanned, points=scanned.points * np.array(factors)))
    (suspicion,) = refused.value.suspicions
    assert says in suspicion.sentence and "in the mapping" in suspicion.sentence
    assert suspicion.rms_after < 0.5e-3 < 5e-3 < suspicion.rms_before


def test_a_touch_probe_has_no_columns_to_convert():
    """The tip is the measured point, so there is no table of points."""
    probed = make_scene("vs060", "probe", poses_per_plane=12, noise=1e-4, seed=5).dataset
    assert list(column_units(probed)) == []


@pytest.mark.parametrize(
    ("factors", "says"),
    [
        ((1.0, 1.0, 10.0), "the column z of target right is 10 times too large compared with x and y"),
        ((1.0, 1000.0, 1.0), "the column y of target right is in millimetres, and x and z in metres"),
        ((1000.0,) * 3, "the columns x, y, z of target right are in millimetres"),
    ],
)
def test_a_unit_of_one_target_is_named(factors, says):
    """A mapping states the unit of each column of each target: if one is wrong, target and column are named, and nothing else."""
    rng = np.random.default_rng(3)
    arm = drawn_arm(rng, ("left", "right"))
    sound = arm.dataset(arm.poses(50, rng), rng, noise=2e-5)
    points = sound.points.copy()
    points[sound.point_columns["target"] == 1] *= np.array(factors)
    with pytest.raises(WrongSetup) as refused:
        calibrate(replace(sound, points=points))
    (suspicion,) = refused.value.suspicions
    assert says in suspicion.sentence and "of target right in the mapping" in suspicion.sentence
