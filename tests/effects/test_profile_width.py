"""Profiles that are too wide imitate an error of the range's zero, and are told from it only if the range varies."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.effects.flexible.profile_bow import UnattributedProfileBow, profile_bow
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
    assert len(profile_bow(dataset)) == count
    assert len(RangeOffset().imitators(dataset)) == 3 * count


def test_the_term_takes_a_bow_away():
    """Points whose range is off by 0.6 mm at the ends of the profile lie on their planes again with the correction."""
    dataset = make_scene(kind="line-laser", seed=3, noise=1e-6).dataset
    (effect,) = profile_bow(dataset)
    effect = effect.with_coefficients([6e-4, -1e-4])
    u = dataset.points[:, :1] / effect.half
    ray = dataset.points / np.linalg.norm(dataset.points, axis=1, keepdims=True)
    wrong = replace(dataset, points=dataset.points - (6e-4 * u**2 - 1e-4 * u**3) * ray)
    model = calibrate(dataset).model
    left = Residuals.of(wrong, model).rms(model)
    corrected = replace(model, effects=(effect,)).rebased()
    assert Residuals.of(wrong, corrected).rms(corrected) < 0.05 * left
    assert "0.7 mm" in effect.described_as


def test_a_bowed_profile_is_no_error_of_the_zero():
    """Profiles whose ends are 0.5 mm off leave neither an offset nor a distortion of the range, and only the noise."""
    dataset = make_scene(
        kind="line-laser", seed=3, poses_per_plane=30, points_per_scan=40, noise=2.6e-5, angle_error=2e-3
    ).dataset
    bow = 5e-4 * (dataset.points[:, 0] / 0.115) ** 2
    found = diagnose(replace(dataset, points=dataset.points + np.stack([0 * bow, bow], axis=1)))
    assert not [f.effect.name for f in found.findings if f.has_name]
    assert any(isinstance(f.effect, UnattributedProfileBow) for f in found.findings)
    assert found.shipped.held_out.rms < 3e-5
