"""A tracked arm without effects, fitted, and poses of it that were not measured."""

from __future__ import annotations

import numpy as np

from scalar.data.poses import Poses
from scalar.diagnosis.explained import explained
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.settings import DEFAULTS
from tests.estimation.test_data_sheet_priors import workcell

LIMITS = np.array([2.5, 1.2, 1.2, 2.5, 1.6, 2.5])  # rad


def fitted_arm() -> FittedState:
    """Return the fit of a tracked arm of 40 poses, without effects."""
    dataset, _ = workcell(2, np.random.default_rng(2).uniform(-1, 1, (40, 6)) * LIMITS)
    return explained(dataset, DEFAULTS, lambda stage: None).near_data_sheet().before


def others(count: int = 30) -> Poses:
    """Return poses that were not measured."""
    q = np.random.default_rng(9).uniform(-1, 1, (count, 6)) * LIMITS
    return Poses(q, np.arange(count, dtype=float), {})
