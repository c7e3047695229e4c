"""The poses of further targets on the flange relative to the sensor, to predict one of them by its name."""

from __future__ import annotations

import numpy as np

from scalar.errors import Fault, InvalidInput
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array
from scalar.sensors import on_flange


def sensor_to_target(model: Model, name: str | None) -> Array:
    """Return ``T_sensor_target`` ``(4, 4)``; the identity for the sensor, which is the first of several targets.

    Args:
        model: As calibrated.
        name: Of a target; None for the sensor.

    Raises:
        InvalidInput: No target has that name.
    """
    if name is None:
        return np.eye(4)
    targets = on_flange(model.target)
    names = [] if targets is None else [known for known in targets.names if known]
    if targets is None or name not in names:
        known = f"it has {', '.join(names)}" if names else "it names none; leave out --target"
        raise InvalidInput(Fault("--target", f"the calibration has no target {name!r}; {known}"))
    return targets.transforms[names.index(name)]


def own_screws(model: Model, name: str | None) -> Array:
    """Return how a target moves relative to the sensor with the last k coordinates of ``model.target``, ``(6, k)`` (shift [m], rotation [rad]).

    The axes are those of the sensor's frame; k is 0 for the sensor itself.

    Args:
        model: As calibrated.
        name: Of a target that the model has; None for the sensor.
    """
    return np.zeros((6, 0)) if name is None else on_flange(model.target).derivatives(name)
