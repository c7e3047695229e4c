"""One column of the measured points in another unit than the others is named, with the unit and the key of the mapping."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.column_units import column_units
from scalar.estimation.setup.suspicion import WrongSetup
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def scanned() -> Dataset:
    """Return sixty scans of three planes."""
    return make_scene("vs060", poses_per_plane=20, noise=1e-4, seed=5).dataset


@pytest.mark.parametrize(
    ("factors", "says"),
    [
        ((1000.0, 1.0), "the column x is in millimetres, and z in metres"),
        ((1.0, 1 / 0.0254), "the column z is in inches, and x in metres"),
        ((1.0, 0.001), "the column z is 1000 times too small beside x"),
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
