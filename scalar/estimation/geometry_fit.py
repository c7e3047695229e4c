"""A quick fit of the geometry alone, for checks of the data that need a rough calibration and no standard errors."""

from __future__ import annotations

from scalar.data.dataset import Dataset
from scalar.estimation.least_squares import fit
from scalar.estimation.model import Model
from scalar.estimation.prepare import Prepared, prepare
from scalar.estimation.settings import DEFAULTS, EstimationSettings
from scalar.estimation.sufficiency import check_equations

_TOLERANCE = 1e-6  # relative, on cost and coordinates: enough to compare distances of millimetres


def geometry_fit(
    dataset: Dataset, settings: EstimationSettings = DEFAULTS, *, effects_follow: bool = False
) -> tuple[Model, Prepared]:
    """Return a model whose geometry, sensor and target are fitted coarsely, and the preparation of the dataset.

    If the maker's tolerance is stated, it determines the directions that these poses do not determine. It does not replace equations: the residual of
    fewer equations than unknowns shows nothing.

    Args:
        dataset: What was measured.
        settings: Thresholds.
        effects_follow: As in ``prepare``.

    Raises:
        InvalidInput: The initial guess of a plane is too far off for the fit.
        Undetermined: The data cannot determine the model.
    """
    prepared = prepare(dataset, settings=settings, effects_follow=effects_follow)
    check_equations(dataset, prepared.residuals.measurement, int(prepared.free.sum()))
    found = fit(prepared.residuals, prepared.coarse, prepared.free, tolerance=_TOLERANCE)
    return found.model.rebased(), prepared
