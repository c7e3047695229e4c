"""What a real scanner does: speckle, growth of noise, a crooked lens, edges, gaps and glints, as physics and as statistics."""

import copy

import numpy as np
import pytest

from scalar.simulation import simulate
from scalar.simulation.optics.losses import gaps, glints, mixed_pixels
from scalar.simulation.optics.speckle import speckle_errors
from scalar.simulation.optics.triangulation import Linearity, growth
from scalar.simulation.scanner import Scanner
from scalar.units import DEG
from tests.simulation.injecting import config_with, plan_of

PIXELS = 400
SCANNER = Scanner(15 * DEG, 0.1, 0.45, 50 * DEG, PIXELS, PIXELS, "z")
NOISE = {"range_noise_std_m": 1e-4}
ALL = {
    "speckle_share": 0.8,
    "growth": True,
    "glint_share": 0.02,
    "gap_share": 0.05,
    "edge_share": 0.3,
    "linearity_m": 5e-5,
}


def lines(size, line=4.0, count=60, seed=0):
    """Return the errors of many lines (count, PIXELS)."""
    rng = np.random.default_rng(seed)
    return np.array([speckle_errors(rng, PIXELS, size, line) for _ in range(count)])


def autocorrelation(errors, shift):
    """Return the correlation of errors (K, M) at a distance of some pixels; the mean of all is zero by symmetry."""
    return float((errors[:, shift:] * errors[:, : errors.shape[1] - shift]).mean() / (errors**2).mean())


def scene_with(scanner=None, surface=None, **changes):
    """Return the small scene with a `scanner` block."""
    config = config_with(noise=NOISE, scanner=scanner or {}, surface=surface or {}, **changes)
    return simulate(config, plan=plan_of("ur10e"))


@pytest.mark.parametrize("size", [2.0, 5.0, 12.0])
def test_speckle_is_alike_within_its_size_and_not_beyond(size):
    """Pixels half a speckle apart have correlated errors, pixels farther apart than two do not: the aperture lets no finer detail through."""
    errors = lines(size)
    assert autocorrelation(errors, max(1, round(size / 2))) > 0.2
    beyond = [abs(autocorrelation(errors, round(size * times))) for times in (2.5, 3.5)]
    assert max(beyond) < 0.12


def test_correlation_grows_with_the_speckle_over_the_pixel():
    """Neighbouring pixels of fine speckle are independent; the coarser the speckle, the more their errors correlate."""
    neighbours = [autocorrelation(lines(size, count=30), 1) for size in (0.25, 1.0, 3.0, 10.0)]
    assert abs(neighbours[0]) < 0.15
    assert neighbours == sorted(neighbours)
    assert neighbours[-1] > 0.9


@pytest.mark.parametrize("size, line", [(0.5, 4.0), (3.0, 2.0), (8.0, 6.0)])
def test_speckle_has_the_stated_variance_and_no_mean(size, line):
    """Whatever speckle and line, the error is as large as the data sheet says, and falls to either side alike."""
    errors = lines(size, line, count=120)
    assert np.mean(errors**2) == pytest.approx(1.0, rel=0.15)
    assert abs(errors.mean()) < 0.08


def test_noise_grows_as_triangulation_says():
    """In the middle of the range at normal incidence the noise is the stated one, and without shot noise it grows with the square of the range."""
    middle = np.array([0.275])
    np.testing.assert_allclose(growth(SCANNER, middle, np.ones(1), 0.4), 1.0)
    z = np.linspace(0.1, 0.45, 8)
    ratio = growth(SCANNER, z, np.ones(8), 0.0)
    curvature = np.diff(np.sqrt(ratio), 2)
    np.testing.assert_allclose(curvature, 0.0, atol=1e-12)
    steep = growth(SCANNER, z, np.full(8, 0.5), 0.4) / growth(SCANNER, z, np.ones(8), 0.4)
    assert (steep > 1.0).all() and (np.diff(steep) > 0).all(), "dim light matters most far away"


@pytest.mark.parametrize("seed", range(4))
def test_a_lens_keeps_its_data_sheet_and_its_factory_calibration(seed):
    """The error is smooth, within the stated one over 95 % of the field, and has no offset, gain or tilt."""
    field = Linearity.drawn(5e-5, SCANNER, np.random.default_rng(seed))
    rng = np.random.default_rng(99)
    z = rng.uniform(0.1, 0.45, 4000)
    x = rng.uniform(-1, 1, 4000) * z * np.tan(SCANNER.fan)
    _, dz = field.error(x, z)
    inside = np.quantile(np.abs(dz), 0.95)
    assert 2e-5 < inside < 8e-5
    known = np.column_stack([np.ones_like(x), x, z])
    explained = known @ np.linalg.lstsq(known, dz, rcond=None)[0]
    assert explained.std() < 0.5 * dz.std()
    near = field.error(x + 1e-6, z + 1e-6)[1] - dz
    assert np.abs(near).max() < 1e-7


def test_no_distortion_leaves_points_where_they_are():
    """Without distortion points do not move, and pictures and rays of vision are inverse to each other."""
    field = Linearity.drawn(1.0, SCANNER, np.random.default_rng(0))
    x, z = np.array([0.02, -0.05]), np.array([0.2, 0.4])
    np.testing.assert_allclose(field._point(*field._picture(x, z)), [x, z], atol=1e-14)


def test_pixels_at_an_edge_lie_between_and_none_beyond():
    """Kept pixels err backwards only, by no more than the gate, at one end; the rest of the scan is untouched."""
    rng = np.random.default_rng(1)
    crossing = [mixed_pixels(rng, PIXELS, 1.0, 5e-3) for _ in range(100)]
    for error, kept in crossing:
        assert (error[kept] >= 0).all() and (error[kept] <= 5e-3).all()
        lost = np.flatnonzero(~kept)
        assert len(lost) and (lost[0] == 0 or lost[-1] == PIXELS - 1) and (np.diff(lost) == 1).all()
        assert (error[kept] < 1e-9).mean() > 0.9
    assert np.mean([(error[kept] > 1e-4).sum() for error, kept in crossing]) > 0.5
    whole = mixed_pixels(rng, PIXELS, 0.0, 5e-3)
    assert not whole[0].any() and whole[1].all()


def test_gaps_and_glints_have_their_shares():
    """Gaps take about the stated share in runs of the stated length; glints make the noise of their share larger."""
    rng = np.random.default_rng(2)
    seen = np.array([gaps(rng, PIXELS, 0.1, 5.0) for _ in range(300)])
    assert 1 - seen.mean() == pytest.approx(0.1, rel=0.15)
    starts = (seen[:, :-1] & ~seen[:, 1:]).sum()
    assert (~seen).sum() / starts == pytest.approx(5.0, rel=0.15)
    factors = np.array([glints(rng, PIXELS, 0.05, 4.0) for _ in range(300)])
    assert (factors > 1).mean() == pytest.approx(0.05, rel=0.1)
    assert factors[factors > 1].mean() == pytest.approx(5.0, rel=0.1)


def test_nothing_stated_changes_nothing():
    """With every amplitude at zero, the sizes of speckle and gaps change no byte."""
    plain = scene_with()
    idle = scene_with({"speckle_pixels": 7.0, "gap_pixels": 9.0, "shot_share": 0.1}, {"waves": 3})
    assert plain.scans.equals(idle.scans) and plain.truth == idle.truth


def test_same_seed_same_bytes_and_the_truth_knows():
    """A scanner with all its faults gives the same tables twice, and truth.json says what they were."""
    first, second = scene_with(ALL), scene_with(ALL)
    assert first.scans.equals(second.scans) and first.truth == second.truth
    assert first.truth["scanner"]["speckle_share"] == 0.8
    assert len(first.scans) == first.seen.sum() < first.seen.size
    assert not first.scans.isna().any().any()
    counts = first.scans.groupby("pose").size()
    assert len(counts) == len(first.poses) and counts.min() >= 5


def test_faults_leave_the_arm_and_its_poses_alone():
    """Only measuring differs: postures, frames and true ranges are those of the scene without."""
    plain, faulty = scene_with(), scene_with(ALL)
    np.testing.assert_array_equal(plain.T_base_sensor, faulty.T_base_sensor)
    np.testing.assert_array_equal(plain.ranges, faulty.ranges)
    assert plain.poses.equals(faulty.poses)


def test_the_first_scans_stay_when_more_are_asked_for():
    """Each scan draws from a generator of its own, so a longer run begins with the shorter one's speckle."""
    config = config_with(noise=NOISE, scanner=ALL, order="by_plane")
    few = copy.deepcopy(config) | {"poses_per_plane": 5}
    many, short = simulate(config, plan=plan_of("ur10e")), simulate(few, plan=plan_of("ur10e"))
    np.testing.assert_array_equal(short.points[:5], many.points[:5])
