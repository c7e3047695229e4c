"""Random poses within the joint limits, at which models of one arm are compared: the same for every calibration of an arm."""

from __future__ import annotations

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.model import Model

_SEED = 0
_TEMPERATURE = (10.0, 30.0)  # deg C: a workshop's


def random_poses(model: Model, count: int) -> Poses:
    """Return poses with uniform joint angles, and with what effects may ask for: directions of approach, a temperature.

    Args:
        model: Of the arm.
        count: How many.
    """
    rng = np.random.default_rng(_SEED)
    limits = model.nominal.limits
    q = rng.uniform(limits[:, 0], limits[:, 1], (count, len(limits)))
    columns = {"approach": rng.choice([-1.0, 1.0], q.shape), "temperature": rng.uniform(*_TEMPERATURE, count)}
    return Poses.from_arrays(q, columns, q.shape[1])
