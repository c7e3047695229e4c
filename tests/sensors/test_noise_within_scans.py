"""The noise within scans as a whole: white noise of one size is left alone, anything else is measured, and a bow is no noise."""

import numpy as np
import pytest

from scalar.estimation.settings import DEFAULTS
from scalar.sensors import measure
from scalar.sensors.within_scan_noise import estimate, noise_within_scans
from scalar.sensors.within_scan_noise.correlation import correlated_parts, sample_of
from scalar.sensors.within_scan_noise.kernels import Part
from scalar.sensors.within_scan_noise.level import Level
from scalar.sensors.within_scan_noise.whiteness import Whiteness
from tests.random_scene import make_scene
from tests.sensors.profiles_of_scans import (
    SIGMA,
    Noise,
    autoregressive,
    growing,
    profiles_of,
    waves,
    white,
)


def found_in(profiles, sigma_stated=True):
    """Return the noise of profiles under the thresholds that the package has."""
    return noise_within_scans(profiles, SIGMA, sigma_stated, DEFAULTS.within_scan_noise)


def test_white_noise_is_left_alone(rng):
    """In forty sets of white noise as stated there is nothing to say."""
    assert all(found_in(profiles_of(white, rng, scans=30, points=(20, 60))) is None for _ in range(40))


def test_too_little_data_say_nothing(rng):
    """Nine scans, or scans of eleven points, say nothing of their noise, and neither do points without noise."""
    assert found_in(profiles_of(autoregressive(0.9), rng, scans=9)) is None
    assert found_in(profiles_of(autoregressive(0.9), rng, points=11)) is None
    assert found_in(profiles_of(lambda rng, angles, along, ranges: 0.0 * angles, rng)) is None


@pytest.mark.parametrize("rho", [0.6, 0.8, 0.9])
def test_correlation_along_the_rays_is_measured(rho, rng):
    """Autoregressive noise is the scanner's; its length, -1 / ln rho points, and its size lie within four standard errors."""
    noise = found_in(profiles_of(autoregressive(rho), rng))
    assert noise is not None
    component = noise.components[0]
    assert component.name == "scan_correlation" and component.target["shape"] == "exponential"
    length, std = component.target["length_points"], component.target["length_std_points"]
    assert abs(length + 1.0 / np.log(rho)) < 4.0 * std
    assert noise.sigma == pytest.approx(SIGMA, rel=0.15)


def test_waves_of_the_surface_are_not_the_scanner(rng):
    """Waves of 0.05 mm, 40 mm long, seen from many distances, are of the surface, and as high as they are."""
    noise = found_in(profiles_of(waves(5e-5, 0.04), rng))
    assert noise is not None
    component = noise.components[0]
    assert component.name == "surface_waviness"
    assert component.value == pytest.approx(5e-5, rel=0.25)


def test_growth_with_the_range_is_measured(rng):
    """Independent noise that grows with the square of the range: the exponent within four standard errors, every scan's level to a tenth."""
    profiles = profiles_of(growing(2.0), rng, scans=150)
    noise = found_in(profiles)
    assert noise is not None
    exponent = next(c for c in noise.components if c.target == {"by": "range"})
    assert abs(exponent.value - 2.0) < 4.0 * exponent.std
    level = noise.sigma * noise.level
    np.testing.assert_allclose(level, SIGMA * (np.exp(profiles.log_range) / 0.25) ** 2, rtol=0.15)
    assert not any(c.name == "scan_correlation" for c in noise.components)


def test_a_noise_that_is_stated_wrong_is_measured(rng):
    """White noise of half the stated size is white noise of that size; where nothing is stated, it is known already."""
    profiles = profiles_of(lambda *scan: 0.5 * white(*scan), rng)
    noise = found_in(profiles)
    assert noise is not None and [c.name for c in noise.components] == ["scan_level"]
    assert noise.sigma == pytest.approx(0.5 * SIGMA, rel=0.05)
    np.testing.assert_allclose(noise.whitening, np.broadcast_to(np.eye(3), noise.whitening.shape), atol=1e-9)
    assert found_in(profiles_of(white, rng), sigma_stated=False) is None


def test_a_bow_is_no_noise(rng):
    """Planes bowed by 2 mm over a metre: white noise stays white, and correlation is measured as though they were flat."""
    assert found_in(profiles_of(white, rng, bow=2e-3)) is None
    seeds = rng.spawn(2)
    lengths = [
        found_in(profiles_of(autoregressive(0.8), np.random.default_rng(7), bow=bow)).components[0].target
        for bow in (0.0, 2e-3)
    ]
    assert len(seeds) == 2
    assert lengths[1]["length_points"] == pytest.approx(lengths[0]["length_points"], rel=0.1)


def test_stray_points_count_for_little(rng):
    """Two points in a hundred that are off by twenty standard deviations make no correlation."""

    def stray(rng, angles, along, ranges):
        off = rng.random(len(angles)) < 0.02
        return white(rng, angles, along, ranges) + 20 * SIGMA * off * rng.choice([-1, 1], len(angles))

    noise = found_in(profiles_of(stray, rng))
    assert noise is None or all(c.name == "scan_level" for c in noise.components)


@pytest.mark.parametrize("kind", ["probe", "tracker"])
def test_a_kind_without_profiles_offers_nothing(kind):
    """A measurement of a few numbers a pose says nothing of its own noise, and is what it was when told that."""
    scene = make_scene(kind=kind, poses_per_plane=12)
    measurement = measure(scene.dataset)
    T = scene.truth.sensor(scene.dataset.q)
    target = measurement.initial_target(scene.dataset)
    assert measurement.noise_within_poses(T, target, DEFAULTS.within_scan_noise) is None
    assert measurement.given_noise(None) is measurement
    assert measurement.noise_components == ()


def correlated(noise: Noise, seed: int, scans: int) -> tuple[Part, ...]:
    """Return the components of the correlation in scans of forty points."""
    profiles, everything = (
        profiles_of(noise, np.random.default_rng(seed), scans, points=40),
        np.ones(scans, dtype=bool),
    )
    sample, _ = sample_of(profiles, profiles.about_lines(everything), np.ones(scans), everything, 0.7 / 39)
    return correlated_parts(sample, DEFAULTS.within_scan_noise)


@pytest.mark.parametrize(("rho", "seed", "is_found"), [(0.15, 0, False), (0.3, 1, True)])
def test_a_correlation_has_to_gain_much(rho, seed, is_found):
    """Thirty scans: a correlation of 0.15 gains 14 nats and is left alone, one of 0.3 gains 36."""
    assert bool(correlated(autoregressive(rho), seed, 30)) == is_found


def test_what_is_longer_than_a_quarter_of_a_scan_is_no_noise_within_it():
    """A correlation over a third of the scan is found as long as is allowed: 9.75 of the 39 steps between its points."""

    def long(rng, angles, along, ranges):
        covariance = np.exp(-np.abs(angles[:, None] - angles) / (0.3 * np.ptp(angles)))
        smooth = np.linalg.cholesky(covariance + 1e-9 * np.eye(len(angles))) @ rng.standard_normal(
            len(angles)
        )
        return SIGMA * smooth + 0.5 * white(rng, angles, along, ranges)

    assert 0.2 * 39 < correlated(long, 0, 60)[0].length < 0.26 * 39


@pytest.mark.parametrize("what", ["correlation", "level"])
@pytest.mark.parametrize(("chance", "is_found"), [(0.7e-6, True), (1.5e-6, False)])
def test_noise_is_white_and_as_stated_unless_that_is_far_beyond_chance(
    what, chance, is_found, rng, monkeypatch
):
    """Chances of 0.7 and of 1.5 in a million."""
    tests = chance if what == "correlation" else 1.0, chance if what == "level" else 1.0
    looked: list[bool] = []
    monkeypatch.setattr(estimate, "whiteness", lambda *_: Whiteness(np.zeros(8), np.ones(8), tests[0]))
    monkeypatch.setattr(estimate, "correlated_parts", lambda *_: looked.append(True) or ())
    level = Level(np.zeros(4), np.eye(4), 1.0, tests[1], np.ones(60))
    monkeypatch.setattr(Level, "of", lambda *_: level)
    noise = found_in(profiles_of(white, rng))
    assert (bool(looked) or noise is not None) == is_found
