"""What the normal equations give is what orthogonal factors give, and where their digits do not suffice they say so."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scalar.estimation.identifiability import _null_space_of_scaled, _null_space_within
from scalar.estimation.least_squares import covariance_and_step
from scalar.estimation.normal_equations import NormalEquations, factor_if_conditioned, solved, solved_by

SEEDS = st.integers(0, 2**32 - 1)
TOLERANCE = 1e-8


def rows(seed, columns=6, count=40):
    """Return a Jacobian whose columns differ in length by orders of magnitude, and a residual."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, columns)) * 10.0 ** rng.uniform(-3, 3, columns), rng.normal(size=count)


@given(SEEDS)
@settings(max_examples=20)
def test_variances_and_step_are_those_of_orthogonal_factors(seed):
    """With and without priors, to eight digits."""
    J, r = rows(seed)
    index, off, slope = np.array([1, 4]), np.array([0.5, -2.0]), np.array([3.0, 0.1])
    below = np.zeros((2, 6))
    below[[0, 1], index] = slope
    own = NormalEquations.of(r, J)
    for found, J_all, r_all in (
        (own, J, r),
        (own.with_priors(index, off, slope), np.vstack([J, below]), np.append(r, off)),
    ):
        covariance, step = covariance_and_step(J_all, r_all)
        np.testing.assert_allclose(found.variances(), np.diag(covariance), rtol=1e-8)
        assert found.step() == pytest.approx(step, rel=1e-8)
        stated = found.covariance_and_step()
        std = np.sqrt(np.diag(covariance))
        np.testing.assert_allclose(stated[0] / np.outer(std, std), covariance / np.outer(std, std), atol=1e-8)
        np.testing.assert_array_equal(stated[0], stated[0].T)
        assert stated[1] == found.step()
        assert found.squares == pytest.approx(r_all @ r_all)


@pytest.mark.parametrize("apart", [1e-7, 0.0])
def test_columns_that_hardly_differ_have_too_few_digits(apart):
    """Of two columns that agree to seven digits, or all, neither variances nor a step are stated; nor of a column of zeros."""
    J, r = rows(0)
    J[:, 3] = J[:, 2] * (1 + apart * r)
    for each in (J, J * [1, 1, 0, 1, 1, 1]):
        found = NormalEquations.of(r, each)
        assert found.variances() is None
        assert found.step() is None
        assert found.covariance_and_step() is None


@given(SEEDS)
@settings(max_examples=20)
def test_whether_all_changes_are_longer_is_what_the_least_singular_value_says(seed):
    """For limits on both sides of the least singular value; at it, rounding decides, and nothing is said."""
    J, r = rows(seed)
    scale = 1.0 / np.linalg.norm(J, axis=0)
    least = np.linalg.svd(J * scale, compute_uv=False)[-1]
    found = NormalEquations.of(r, J)
    assert found.all_longer(scale, 0.999 * least) is True
    assert found.all_longer(scale, 1.001 * least) is False
    assert found.all_longer(scale, least) is None


@pytest.mark.parametrize("definite", [True, False])
def test_a_solution_and_the_diagonal_of_the_inverse(definite):
    """Both are those of the inverse, also of a matrix that is not positive definite."""
    J, r = rows(1, columns=5)
    A = J.T @ J + np.diag(np.full(5, 0.0 if definite else -2.0 * np.trace(J.T @ J)))
    x, diagonal = solved(A, r[:5])
    np.testing.assert_allclose(A @ x, r[:5], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(diagonal, np.linalg.inv(A).diagonal(), rtol=1e-6)


@pytest.mark.parametrize("within", ["all", "a part", "none"])
@pytest.mark.parametrize("values", [[0.0, 0.0], [1e-12, 0.0], [2e-8, 0.0], [1e-7, 1e-12], [1e-3, 0.5]])
def test_a_null_space_is_the_same_wherever_it_is_expected(values, within):
    """Far from the tolerance and near it, all singular values give the same null space, whatever the expected space holds of it."""
    rng = np.random.default_rng(3)
    U, V = (np.linalg.qr(rng.normal(size=shape))[0] for shape in ((30, 8), (8, 8)))
    J = U * np.append(np.linspace(1.0, 0.3, 6), values) @ V.T
    space = {"all": V[:, 5:], "a part": V[:, [4, 7]], "none": V[:, :2]}[within]
    found, expected = _null_space_within(J, space, TOLERANCE), _null_space_of_scaled(J, TOLERANCE)[1]
    np.testing.assert_allclose(found @ found.T, expected @ expected.T, atol=1e-7)


@given(SEEDS)
@settings(max_examples=20)
def test_a_factor_is_given_where_the_condition_number_is_certainly_small(seed):
    """Its solution is that of the equations; a matrix beyond the limit has none, and neither has one that is not positive."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(5, 5)))[0]
    for largest, most, given_factor in ((1e3, 1e5, True), (1e6, 1e5, False), (-1.0, 1e5, False)):
        gram = (axes * np.r_[1.0, 2.0, 3.0, 4.0, largest]) @ axes.T
        factor = factor_if_conditioned(gram, most)
        assert (factor is not None) == given_factor
        if factor is not None:
            right = rng.normal(size=5)
            np.testing.assert_allclose(solved_by(factor, right), np.linalg.solve(gram, right), rtol=1e-9)
