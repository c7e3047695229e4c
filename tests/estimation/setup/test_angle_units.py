"""Joint angles in another unit are recognised where the fit is far off, or where the arm hardly moves as described."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.arm.angle_units import angle_units
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.units import DEG, MM
from tests.random_scene import make_scene

SCENES = {
    "tracker": {"poses_per_plane": 25, "seed": 7},
    "probe": {"poses_per_plane": 40, "seed": 2},
    "line-laser": {"poses_per_plane": 30, "points_per_scan": 12, "seed": 5},
}


def scaled(dataset: Dataset, factor: float) -> Dataset:
    """Return the dataset with all joint angles multiplied by a factor."""
    columns = {f"q{j + 1}": dataset.q[:, j] * factor for j in range(6)}
    return replace(dataset, poses=dataset.poses.assign(**columns))


@pytest.mark.parametrize(
    "kind", ["tracker", *(pytest.param(k, marks=pytest.mark.slow) for k in ("probe", "line-laser"))]
)
@pytest.mark.parametrize(
    ("factor", "says"),
    [
        (DEG, "were radians, converted as if they were degrees"),
        (1 / DEG, "are in degrees, not in radians"),
        (1 / 0.9, "were grads, converted as if they were degrees"),
    ],
)
def test_units_taken_for_one_another_are_named(kind, factor, says):
    """With any sensor one sentence says which unit the angles have, and the residual with it, which is that of a sound dataset.

    On planes an arm that hardly moves leaves no residual, so that the residual before need not be large.
    """
    dataset = make_scene("vs060", kind, noise=1e-4, **SCENES[kind]).dataset
    with pytest.raises(WrongSetup) as refused:
        calibrate(scaled(dataset, factor))
    (suspicion,) = refused.value.suspicions
    assert (suspicion.what, suspicion.where) == ("angle_unit", "poses.csv")
    assert says in suspicion.sentence and "mm" in suspicion.sentence
    assert suspicion.rms_after is not None and suspicion.rms_after < 0.3 * MM


def test_degrees_of_small_motions_are_read_too():
    """Where a tracker measured, degrees are recognised however small the range of the joints; a residual on planes would show nothing."""
    for kind, tried in (("tracker", True), ("probe", False)):
        dataset = make_scene("vs060", kind, noise=1e-4, **SCENES[kind]).dataset
        small = scaled(dataset, 0.01 / DEG)
        said = [alternative.says for alternative in angle_units(small)]
        assert any("are in degrees" in text for text in said) == tried


def test_radians_are_tried_only_where_the_arm_hardly_moves():
    """Angles multiplied by 57 would be many turns for any arm that moves as described, so its dataset has no such alternative."""
    dataset = make_scene("vs060", "tracker", noise=1e-4, **SCENES["tracker"]).dataset
    for factor, tried in ((1.0, False), (DEG, True)):
        found = [a for a in angle_units(scaled(dataset, factor)) if "were radians" in a.says]
        assert bool(found) == tried
        for alternative in found:
            np.testing.assert_allclose(alternative.dataset.q, dataset.q, rtol=1e-12)
