"""The noise within scans: white noise of one size gives None, any other noise is estimated, and a bowed plane is not noise."""

import numpy as np
import pytest

from scalar.estimation.settings import DEFAULTS
from scalar.sensors import measure
from scalar.sensors.within_scan_noise import estimate, noise_within_scans
from scalar.sensors.within_scan_noise.correlation import correlated_parts, sample_of
from scalar.sensors.within_scan_noise.correlation_shapes import Part
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
    """Return the noise of profiles with the package's default thresholds."""
    return noise_within_scans(profiles, SIGMA, sigma_stated, DEFAULTS.within_scan_noise)


def test_white_noise_is_left_alone(rng):
    """Forty sets of white noise of the stated size all give None."""
    assert all(found_in(profiles_of(white, rng, scans=30, points=(20, 60))) is None for _ in range(40))


def test_too_few_data_give_no_noise(rng):
    """Nine scans, scans of eleven points, and points without noise give None."""
    assert found_in(profiles_of(autoregressive(0.9), rng, scans=9)) is None
    assert found_in(profiles_of(autoregressive(0.9), rng, points=11)) is None
    assert found_in(profiles_of(lambda rng, angles, along, ranges: 0.0 * angles, rng)) is None


@pytest.mark.parametrize("rho", [0.6, 0.8, 0.9])
def test_correlation_along_the_rays_is_measured(rho, rng):
    """Autoregressive noise is attributed to the scanner; its length, -1 / ln rho points, is found within four standard errors, its size to 15 %."""
    noise = found_in(profiles_of(autoregressive(rho), rng))
    assert noise is not None
    component = noise.components[0]
    assert component.name == "scan_correlation" and component.target["shape"] == "exponential"
    length, std = component.target["length_points"], component.target["length_std_points"]
    assert abs(length + 1.0 / np.log(rho)) < 4.0 * std
    assert noise.sigma == pytest.approx(SIGMA, rel=0.15)


def test_waves_are_attributed_to_the_surface(rng):
    """Waves of 0.05 mm, 40 mm long, scanned from many distances, are attributed to the surface; their height is found to a quarter."""
    noise = found_in(profiles_of(waves(5e-5, 0.04), rng))
    assert noise is not None
    component = noise.components[0]
    assert component.name == "surface_waviness"
    assert component.value == pytest.approx(5e-5, rel=0.25)


def test_growth_with_the_range_is_measured(rng):
    """For noise that grows with the square of the range, the exponent is found within four standard errors, and every scan's level to 15 %."""
    profiles = profiles_of(growing(2.0), rng, scans=150)
    noise = found_in(profiles)
    assert noise is not None
    exponent = next(c for c in noise.components if c.target == {"by": "range"})
    assert abs(exponent.value - 2.0) < 4.0 * exponent.std
    level = noise.sigma * noise.level
    np.testing.assert_allclose(level, SIGMA * (np.exp(profiles.log_range) / 0.25) ** 2, rtol=0.15)
    assert not any(c.name == "scan_correlation" for c in noise.components)


def test_a_noise_that_is_stated_wrong_is_measured(rng):
    """White noise of half the stated size is found with its true size; if no noise is stated, white noise gives None."""
    profiles = profiles_of(lambda *scan: 0.5 * white(*scan), rng)
    noise = found_in(profiles)
    assert noise is not None and [c.name for c in noise.components] == ["scan_level"]
    assert noise.sigma == pytest.approx(0.5 * SIGMA, rel=0.05)
    np.testing.assert_allclose(noise.whitening, np.broadcast_to(np.eye(3), noise.whitening.shape), atol=1e-9)
    assert found_in(profiles_of(white, rng), sigma_stated=False) is None


def test_a_bowed_plane_is_not_noise(rng):
    """On planes bowed by 2 mm over a metre white noise stays white, and correlation is estimated as on flat planes."""
    assert found_in(profiles_of(white, rng, bow=2e-3)) is None
    lengths = [
        found_in(profiles_of(autoregressive(0.8), np.random.default_rng(7), bow=bow)).components[0].target
        for bow in (0.0, 2e-3)
    ]
    assert lengths[1]["length_points"] == pytest.approx(lengths[0]["length_points"], rel=0.1)


def test_the_curvature_of_a_plane_is_removed_from_scans_of_any_tilt():
    """Without noise, next to nothing of a bow remains about the scans' own lines, however the scanner's plane is tilted against the target."""
    rng = np.random.default_rng(3)
    profiles = profiles_of(lambda rng, angles, along, ranges: 0.0 * angles, rng, bow=2e-3)
    bent = profiles.without(profiles.height, 2)
    left = profiles.about_lines(np.ones(len(profiles.counts), dtype=bool))
    assert np.linalg.norm(left) < 0.01 * np.linalg.norm(bent)


def test_stray_points_count_for_little(rng):
    """If two points in a hundred are off by twenty standard deviations, no correlation is found."""

    def stray(rng, angles, along, ranges):
        off = rng.random(len(angles)) < 0.02
        return white(rng, angles, along, ranges) + 20 * SIGMA * off * rng.choice([-1, 1], len(angles))

    noise = found_in(profiles_of(stray, rng))
    assert noise is None or all(c.name == "scan_level" for c in noise.components)


@pytest.mark.parametrize("kind", ["probe", "tracker"])
def test_a_kind_without_scans_estimates_no_noise_within_poses(kind):
    """A kind with a few numbers at each pose gives None, and giving it None back leaves the measurement unchanged."""
    scene = make_scene(kind=kind, poses_per_plane=12)
    measurement = measure(scene.dataset)
    T = scene.truth.sensor(scene.dataset.q)
    target = measurement.initial_target(scene.dataset)
    assert measurement.noise_within_poses(T, target, DEFAULTS.within_scan_noise) is None
    assert measurement.given_noise(None) is measurement
    assert measurement.noise_components == ()


def correlated(noise: Noise, seed: int, scans: int) -> tuple[Part, ...]:
    """Return the components of correlation that are found in scans of forty points."""
    profiles, everything = (
        profiles_of(noise, np.random.default_rng(seed), scans, points=40),
        np.ones(scans, dtype=bool),
    )
    sample, _ = sample_of(profiles, profiles.about_lines(everything), np.ones(scans), everything, 0.7 / 39)
    return correlated_parts(sample, DEFAULTS.within_scan_noise)


@pytest.mark.parametrize(("rho", "seed", "is_found"), [(0.15, 0, False), (0.3, 1, True)])
def test_a_correlation_needs_a_gain_in_likelihood(rho, seed, is_found):
    """In thirty scans a correlation of 0.15 gains 14 nats, which is too few for a component, and one of 0.3 gains 36, which is enough."""
    assert bool(correlated(autoregressive(rho), seed, 30)) == is_found


def test_correlation_lengths_are_at_most_a_quarter_of_a_scan():
    """A correlation over a third of the scan is found with the largest length allowed: 9.75 of the 39 steps between points."""

    def long(rng, angles, along, ranges):
        covariance = np.exp(-np.abs(angles[:, None] - angles) / (0.3 * np.ptp(angles)))
        smooth = np.linalg.cholesky(covariance + 1e-9 * np.eye(len(angles))) @ rng.standard_normal(
            len(angles)
        )
        return SIGMA * smooth + 0.5 * white(rng, angles, along, ranges)

    assert 0.2 * 39 < correlated(long, 0, 60)[0].length < 0.26 * 39


@pytest.mark.parametrize("what", ["correlation", "level"])
@pytest.mark.parametrize(("chance", "is_found"), [(0.7e-6, True), (1.5e-6, False)])
def test_noise_is_white_and_as_stated_unless_a_test_is_significant(what, chance, is_found, rng, monkeypatch):
    """A p-value of 0.7 in a million is significant, for correlation and for the level; one of 1.5 is not."""
    tests = chance if what == "correlation" else 1.0, chance if what == "level" else 1.0
    looked: list[bool] = []
    monkeypatch.setattr(estimate, "whiteness", lambda *_: Whiteness(np.zeros(8), np.ones(8), tests[0]))
    monkeypatch.setattr(estimate, "correlated_parts", lambda *_: looked.append(True) or ())
    level = Level(np.zeros(4), np.eye(4), 1.0, tests[1], np.ones(60))
    monkeypatch.setattr(Level, "of", lambda *_: level)
    noise = found_in(profiles_of(white, rng))
    assert (bool(looked) or noise is not None) == is_found
