"""A stand-in for a state whose rows scatter by an error of each pose, for tests of what neighbouring poses have in common."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.variance_components import VarianceComponent
from scalar.diagnosis.noise import smooth_share

ROWS = 3  # of a pose


def scattered(
    monkeypatch: pytest.MonkeyPatch,
    rng: np.random.Generator,
    name: str,
    errors: np.ndarray,
    per_unit: float,
    std: float,
    **of_dataset: Any,
) -> tuple[Any, VarianceComponent]:
    """Return the stand-in, and the variance component that describes the errors; the model explains ten random directions of the rows.

    Args:
        monkeypatch: Of the test.
        rng: Draws the noise, the derivatives and the directions of the model.
        name: Of the component.
        errors: ``(N, k)`` [rad or m], of k kinds at each pose.
        per_unit: Size of the derivatives of whitened rows by an error [1/rad or 1/m].
        std: Standard deviation of the errors, as the component has it.
        of_dataset: What is asked of the dataset.
    """
    N, k = errors.shape
    D = rng.normal(size=(N, ROWS, k)) * per_unit
    z = rng.normal(size=(N, ROWS)) + np.einsum("nmk,nk->nm", D, errors)
    background = Background.of(z.ravel(), rng.normal(size=(N * ROWS, 10)), N, ROWS)
    covariance = np.eye(ROWS) + std**2 * D @ np.swapaxes(D, 1, 2)
    monkeypatch.setattr(smooth_share, "directions", lambda *_: [(name, D)])
    state = SimpleNamespace(
        dataset=SimpleNamespace(**of_dataset),
        residuals=None,
        model=None,
        background_within_scans=lambda: background,
        once=lambda key, compute: compute(),
    )
    return state, VarianceComponent(name, std, 1e-5, 50.0, 1e-9, covariance)
