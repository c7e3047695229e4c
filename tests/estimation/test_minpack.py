"""MINPACK's pivoting is that of LAPACK, and its path does not depend on memory outside its arrays."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize

from scalar.estimation.minpack import levenberg_marquardt
from scalar.geometry.se3 import Array


def nearly_dependent(seed: int, rows: int = 40, columns: int = 8) -> Array:
    """Return a matrix whose second half of columns is the first half, changed by 1e-10 to 1e-7."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(rows, columns))
    half = columns // 2
    A[:, half:] = A[:, :half] + rng.normal(size=(rows, half)) * 10.0 ** rng.uniform(-10, -7, half)
    return A


@pytest.mark.parametrize("seed", range(6))
def test_columns_are_eliminated_in_the_order_in_which_lapack_eliminates_them(seed, monkeypatch):
    A = nearly_dependent(seed)
    leastsq = scipy.optimize.leastsq
    seen: list[Array] = []

    def recorded(*arguments, **options):
        found: Any = leastsq(*arguments, **options)
        seen.append(found[2]["ipvt"])
        return found

    monkeypatch.setattr(scipy.optimize, "leastsq", recorded)
    levenberg_marquardt(lambda x: A @ x - 1.0, lambda x: A, np.zeros(A.shape[1]), max_evaluations=100)
    *_, order = scipy.linalg.qr(A, mode="r", pivoting=True)
    assert seen[0][0] == 0 and seen[0][-1] == A.shape[1] + 1  # the two parameters that guard the others
    np.testing.assert_array_equal(seen[0][1:-1] - 1, order)


def test_the_path_does_not_depend_on_what_memory_holds():
    """SciPy's own ``leastsq`` ends this problem in ten ways, by what lies beyond its arrays."""
    A = nearly_dependent(3, 60, 12)
    rng = np.random.default_rng(1)
    kept: list[Array] = []
    paths = set()
    for _ in range(60):
        kept = [*kept[-20:], np.full(rng.integers(1, 3000), rng.normal() * 10.0 ** rng.integers(-8, 3))]
        path: list[bytes] = []

        def jacobian(x, path=path):
            path.append(x.tobytes())
            return A * np.cos(x) + 0.6 * (A @ x)[:, None] * A

        levenberg_marquardt(
            lambda x: A @ np.sin(x) - 1.0 + 0.3 * (A @ x) ** 2,
            jacobian,
            np.full(12, 0.3),
            max_evaluations=200,
        )
        paths.add(b"".join(path))
    assert len(paths) == 1


def test_the_optimum_is_that_of_linear_algebra():
    rng = np.random.default_rng(5)
    A, b = rng.normal(size=(30, 7)), rng.normal(size=30)
    x, message, info = levenberg_marquardt(lambda x: A @ x - b, lambda x: A, np.zeros(7), max_evaluations=50)
    np.testing.assert_allclose(x, np.linalg.lstsq(A, b)[0], atol=1e-12)
    assert info in (1, 2, 3, 4) and message


def test_a_parameter_that_moves_nothing_stays_where_it_is():
    rng = np.random.default_rng(6)
    A = np.column_stack([rng.normal(size=(20, 3)), np.zeros(20)])
    start = np.array([0.0, 0.0, 0.0, 0.7])
    x, _, info = levenberg_marquardt(lambda x: A @ x - 1.0, lambda x: A, start, max_evaluations=50)
    assert x[3] == 0.7 and info in (1, 2, 3)
