"""Profiles that are too wide imitate an error of the range's zero, and are told from it only if the range varies."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.effects.flexible.profile_width import UnattributedProfileWidth, profile_width
from scalar.effects.range_offset import RangeOffset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.residuals import Residuals
from tests.random_scene import make_scene


def test_the_term_takes_the_error_of_the_width_away():
    """Points whose x is 3 mm per m too short lie on their planes again with the correction; the width is not z's."""
    scene = make_scene(kind="line-laser", seed=3, noise=1e-6)
    dataset, gain = scene.dataset, 3e-3
    short = dataset.points * np.array([1 / (1 + gain), 1.0])
    model = calibrate(dataset).model
    wrong = replace(dataset, points=short)
    left = Residuals.of(wrong, model).rms(model)
    corrected = replace(model, effects=(UnattributedProfileWidth().with_coefficients([gain]),)).rebased()
    assert Residuals.of(wrong, corrected).rms(corrected) < 0.05 * left


@pytest.mark.parametrize(("kind", "count"), [("line-laser", 1), ("tracker", 0), ("probe", 0)])
def test_only_scanners_of_profiles_have_a_width(kind, count):
    """The range's zero has it as a rival, with a scanner of profiles alone."""
    dataset = make_scene(kind=kind, seed=2, poses_per_plane=6).dataset
    assert len(profile_width(dataset)) == count
    assert len(RangeOffset().imitators(dataset)) == count
