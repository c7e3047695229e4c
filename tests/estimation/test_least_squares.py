"""One Levenberg-Marquardt run: certified answers, covariance by our own algebra, and honesty about
convergence.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.errors import NotConverged
from scalar.estimation import joint_fit, least_squares
from scalar.estimation.calibrate import calibrate
from scalar.estimation.least_squares import covariance_and_step, fit
from scalar.estimation.setup import explain as search
from tests.random_scene import make_scene


@dataclass(frozen=True, eq=False)
class Curve:
    """Stands in for a model: b1 (1 - exp(-b2 x))."""

    vector: np.ndarray
    names = ("b 1", "b.2")

    def with_vector(self, vector):
        return replace(self, vector=np.array(vector))


@dataclass(frozen=True, eq=False)
class Misra1a:
    """NIST StRD Misra1a (dental research, lower difficulty): stands in for residuals."""

    x = np.array(
        [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0]
    )
    y = np.array(
        [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.4, 75.47, 81.78]
    )

    known = None

    def plane_problem(self, model):
        return None

    def residual(self, model):
        b1, b2 = model.vector
        return b1 * (1 - np.exp(-b2 * self.x)) - self.y

    def linearise(self, model):
        b1, b2 = model.vector
        e = np.exp(-b2 * self.x)
        return self.residual(model), np.column_stack([1 - e, b1 * self.x * e])


CERTIFIED = np.array([2.3894212918e02, 5.5015643181e-04])
CERTIFIED_STD = np.array([2.7070075241e00, 7.2668688436e-06])
CERTIFIED_SUM = 1.2455138894e-01


@pytest.mark.parametrize("start", [[500.0, 1e-4], [250.0, 5e-4]])
def test_the_fit_gives_the_certified_answer(start):
    """Values, standard deviations and sum of squares agree with NIST's to 9 digits, which double precision allows."""
    found = fit(Misra1a(), Curve(np.array(start)), np.array([True, True]))
    assert found.converged
    np.testing.assert_allclose(found.model.vector, CERTIFIED, rtol=1e-9)
    assert found.chi_squared == pytest.approx(CERTIFIED_SUM, rel=1e-9)
    std = np.sqrt(np.diag(found.covariance) * found.chi_squared / (14 - 2))
    np.testing.assert_allclose(std, CERTIFIED_STD, rtol=1e-8)


def test_held_coordinates_stay():
    """A coordinate that is not free keeps its value to the bit; the other is the optimum beside it."""
    found = fit(Misra1a(), Curve(np.array([240.0, 1e-4])), np.array([False, True]))
    assert found.model.vector[0] == 240.0
    residual, jacobian = Misra1a().linearise(found.model)
    assert abs(jacobian[:, 1] @ residual) < 1e-8 * np.linalg.norm(jacobian[:, 1]) * np.linalg.norm(residual)


@pytest.mark.slow
def test_a_run_that_is_cut_short_is_not_converged(monkeypatch):
    """With three evaluations there is no optimum: the fit says so, and the calibration refuses it with exit status 3."""
    monkeypatch.setattr(least_squares, "MAX_EVALUATIONS", 3)
    assert not fit(Misra1a(), Curve(np.array([500.0, 1e-4])), np.array([True, True])).converged
    monkeypatch.setattr(least_squares, "MAX_EVALUATIONS", 1)
    monkeypatch.setattr(joint_fit, "_ROUNDS", 1)
    monkeypatch.setattr(search, "other_arms", lambda _: ())  # the true arm is one of the library
    scene = make_scene(points_per_scan=10, plane_tilt=0.3, length_error=0.01, angle_error=np.deg2rad(5.0))
    with pytest.raises(NotConverged, match="did not converge") as refusal:
        calibrate(scene.dataset)
    assert refusal.value.exit_status == 3


matrices = st.tuples(st.integers(1, 6), st.integers(0, 20), st.integers(0, 2**32 - 1))


@given(matrices, st.floats(-6, 6))
def test_covariance_is_the_inverse_of_the_normal_matrix(shape, decades):
    """The covariance is ``(J'J)^-1`` even if columns differ by many orders of magnitude, and the step is the projected residual."""
    k, more, seed = shape
    rng = np.random.default_rng(seed)
    J = rng.standard_normal((k + 3 + more, k))
    scale = 10.0 ** np.linspace(0, decades, k)
    r = rng.standard_normal(len(J))
    covariance, step = covariance_and_step(J * scale, r)
    expected = np.linalg.inv(J.T @ J) / np.outer(scale, scale)
    np.testing.assert_allclose(
        covariance, expected, rtol=1e-7, atol=1e-9 * np.sqrt(np.outer(*[np.diag(expected)] * 2)).max()
    )
    projected = J @ np.linalg.lstsq(J, r, rcond=None)[0]
    assert step == pytest.approx(np.linalg.norm(projected) / max(1.0, np.sqrt(np.mean(r**2))), rel=1e-9)


def test_a_direction_that_nothing_shows_gets_no_error_bar_from_rounding():
    """For a rank-deficient matrix the covariance is finite, that of the observed directions, and zero along the other."""
    rng = np.random.default_rng(0)
    J = rng.standard_normal((20, 3)) @ np.array([[1.0, 0, 1], [0, 1, 1], [0, 0, 0]])
    covariance, step = covariance_and_step(J, np.ones(20))
    assert np.isfinite(covariance).all() and np.isfinite(step)
    assert np.abs(covariance).max() < 10


def test_nothing_free_is_a_fit_as_well():
    """Without a free coordinate, the covariance is empty and there is no step."""
    covariance, step = covariance_and_step(np.zeros((5, 0)), np.ones(5))
    assert covariance.shape == (0, 0)
    assert step == 0.0
