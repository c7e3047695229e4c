"""A factor between all lengths of two calibrations is said to be that: an instrument of another scale makes it, and no single link has changed."""

import numpy as np
import pytest

from scalar.cli.compare import describe_comparison
from scalar.comparison import compare
from scalar.geometry.robot import GEOMETRY, LENGTHS
from tests.comparison.arms import arm_before, by_chance, changed


@pytest.fixture(scope="module")
def before():
    """Return a calibration of an arm, before any change."""
    return arm_before()


def stretched(calibration, share, **more):
    """Return a calibration whose lengths are all longer by a share, as a scanner makes them that measures so much too long, and more changes."""
    geometry = calibration.model.robot.geometry
    steps = {
        f"{kind}_{j + 1}": share * geometry[GEOMETRY.index(kind), j]
        for kind in LENGTHS
        for j in range(geometry.shape[1])
    }
    return changed(calibration, **steps, **more)


@pytest.mark.parametrize("share", [8e-4, -8e-4])
def test_another_scale_of_the_instrument_is_no_change_of_single_lengths(before, share):
    """By chance as well, all lengths of B are said to differ by the true share; the arm is not said to have changed."""
    found = compare(before, by_chance(stretched(before, share), np.random.default_rng(5)))
    assert found.stretch is not None and not found.changes and not found.changed
    assert abs(found.stretch.value - share) < 4 * found.stretch.std < 4e-4
    assert abs(found.stretch.moved.rms / found.positions_apart.rms - 1.0) < 0.1
    said = "\n".join(describe_comparison(found))
    assert "the arm changed" not in said and "known length" in said
    assert ("longer" if share > 0 else "shorter") in said
    assert found.to_mapping()["scale_of_all_lengths"]["share"] == pytest.approx(share, abs=2e-4)


def test_a_change_beside_another_scale_is_found(before):
    """A zero that changed is named with its size, and the scale is stated too."""
    found = compare(before, stretched(before, 8e-4, theta_3=1e-3))
    (change,) = found.changes
    assert change.candidate.name == "theta_3" and change.value[0] == pytest.approx(1e-3, rel=0.02)
    assert found.stretch is not None and found.stretch.value == pytest.approx(8e-4, rel=0.05)
    said = describe_comparison(found)
    assert said[0].startswith("the arm changed: 1 change") and any(
        "all lengths of B" in line for line in said
    )


@pytest.mark.parametrize("length", ["a_3", "a_4", "d_5"])
def test_a_single_length_that_changed_is_no_scale(before, length):
    """One link that differs by a millimetre is named, and no factor between all of them."""
    found = compare(before, changed(before, **{length: 1e-3}))
    assert found.stretch is None and [change.candidate.name for change in found.changes] == [length]
    assert "all lengths" not in "\n".join(describe_comparison(found))
