"""Compression of a scan to three rows is exact for every scan, with and without noise, however short."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.sensors.compression import compress, compress_keeping_q, line_basis
from scalar.sensors.profile import point_basis

RELATIVE = 1e-12


def test_functions_of_a_point_are_what_their_names_say():
    """Powers of the coordinates, and the direction of the ray times powers of its length and of the coordinates, at a point 3, 4 from the scanner."""
    names = ("1", "x", "zz", "xz", "ux", "rz", "dx", "uz:30", "ux:12")
    found = point_basis(names, np.array([[3.0, 4.0]]), "ray")
    np.testing.assert_allclose(found, [[1, 3, 16, 12, 0.6, 4, 15, 0.8 * 27, 0.6 * 3 * 16]], rtol=1e-15)
    found = point_basis(("ux", "uz", "rz", "dz", "uz:11"), np.array([[3.0, 4.0]]), "z")
    np.testing.assert_array_equal(found, [[0, 1, 4, 16, 12]])


def scans(rng: np.random.Generator, lengths: list[int], noise: float, vertical: bool = False) -> np.ndarray:
    """Return points ``(P, 2)`` [m] of scans, each on a line up to half a metre from the scanner."""
    points = []
    for M in lengths:
        if vertical:
            line = np.column_stack([np.full(M, 0.07), rng.uniform(0.1, 0.4, M)])
        else:
            x = rng.uniform(-0.1, 0.1, M)
            line = np.column_stack([x, rng.uniform(0.1, 0.5) + rng.uniform(-1, 1) * x])
        points.append(line + noise * rng.standard_normal(line.shape))
    return np.concatenate(points)


def worst_disagreement(points: np.ndarray, lengths: list[int], rng: np.random.Generator) -> float:
    """Return the largest ``||Bc| - |Rc|| / (|B| |c|)`` over the scans and random vectors c."""
    starts = np.r_[0, np.cumsum(lengths)]
    B, R = line_basis(points), compress(line_basis(points), starts)
    worst = 0.0
    for s in range(len(lengths)):
        Bs = B[starts[s] : starts[s + 1]]
        for c in rng.standard_normal((5, 3)):
            gap = abs(np.linalg.norm(Bs @ c) - np.linalg.norm(R[s] @ c))
            worst = max(worst, gap / (np.linalg.norm(Bs) * np.linalg.norm(c)))
    return worst


lengths = st.lists(st.integers(1, 40), min_size=1, max_size=8)


@given(lengths, st.sampled_from([0.0, 1e-9, 1e-4, 1e-2]), st.booleans(), st.integers(0, 2**32 - 1))
def test_the_length_of_the_residual_is_kept(lengths, noise, vertical, seed):
    """``|B c| = |R c|`` holds for every c and scans of any length, noise-free and vertical lines included."""
    rng = np.random.default_rng(seed)
    assert worst_disagreement(scans(rng, lengths, noise, vertical), lengths, rng) < RELATIVE


@given(st.integers(3, 300), st.integers(0, 2**32 - 1))
def test_the_small_residual_at_the_truth_is_kept(M, seed):
    """Near the truth, where ``B c`` is noise of 0.1 mm, its length is kept to a relative 1e-11."""
    rng = np.random.default_rng(seed)
    slope, height = rng.uniform(-1, 1), rng.uniform(0.1, 0.5)
    x = rng.uniform(-0.1, 0.1, M)
    B = line_basis(np.column_stack([x, height + slope * x + 1e-4 * rng.standard_normal(M)]))
    R = compress(B, np.array([0, M]))[0]
    c = np.array([-height, -slope, 1.0])
    assert np.linalg.norm(R @ c) == pytest.approx(np.linalg.norm(B @ c), rel=1e-11)


@given(lengths, st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_the_factor_is_triangular_and_q_orthonormal(lengths, k, seed):
    """For every scan, ``B = Q R``, where R is upper triangular with a diagonal that is not negative, and ``Q'Q`` is a projection."""
    rng = np.random.default_rng(seed)
    starts = np.r_[0, np.cumsum(lengths)]
    basis = rng.standard_normal((starts[-1], k))
    R, Q = compress_keeping_q(basis, starts)
    assert np.all(np.tril(R, -1) == 0)
    assert np.all(np.diagonal(R, axis1=1, axis2=2) >= 0)
    for s, (first, end) in enumerate(itertools.pairwise(starts)):
        np.testing.assert_allclose(Q[first:end] @ R[s], basis[first:end], atol=1e-11)
        gram = Q[first:end].T @ Q[first:end]
        np.testing.assert_allclose(gram @ gram, gram, atol=1e-10)


def test_the_factor_is_that_of_numpy():
    """R is NumPy's Householder factor with the signs of its diagonal made positive."""
    rng = np.random.default_rng(2)
    points = scans(rng, [50, 50], 1e-4)
    R = compress(line_basis(points), np.array([0, 50, 100]))
    for s in range(2):
        expected = np.linalg.qr(line_basis(points)[50 * s : 50 * s + 50], mode="r")
        expected *= np.sign(np.diag(expected))[:, None]
        np.testing.assert_allclose(R[s], expected, atol=1e-13)


def test_a_noise_free_scan_has_rank_two_and_a_single_point_rank_one():
    """Directions that a scan does not determine have exactly zero on the diagonal, not rounding noise."""
    rng = np.random.default_rng(1)
    points = scans(rng, [100, 1, 2], 0.0)
    R = compress(line_basis(points), np.array([0, 100, 101, 103]))
    assert np.all(np.isfinite(R))
    diagonal = np.diagonal(R, axis1=1, axis2=2) > 1e-9
    assert diagonal.sum(axis=1).tolist() == [2, 1, 2]


def test_the_input_is_left_alone():
    """The basis is not changed in place."""
    basis = np.random.default_rng(0).standard_normal((10, 3))
    before = basis.copy()
    compress(basis, np.array([0, 4, 10]))
    np.testing.assert_array_equal(basis, before)
