"""Directions in which planes do not show a motion of the sensor, or hardly, and how uncertain predicted positions are along them.

A scan or a contact tells how far the sensor is from a plane, and a scan also how it is turned against it: a shift at right angles to the normals of
all planes changes no measurement. What moves the sensor along such a direction at one pose moves it along others where the link is turned otherwise,
so that the arm may be determined all the same. What the poses leave open is left to the data sheet, and the covariance contains it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import Undetermined
from scalar.estimation.model import Model
from scalar.estimation.prediction_covariance import pose_deviations
from scalar.estimation.residuals import Residuals
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.geometry.standard_dh import as_stated
from scalar.units import DEG

UNSEEN_DIRECTIONS = "unseen_directions"
"""Key of a calibration's summary: what ``unseen_directions`` returns."""
WEAK_SPAN = float(np.sin(10 * DEG))
"""Singular value of the normals below which planes hardly show a direction, chosen: their noise is multiplied by six along it."""
# Chosen: two plates that are called parallel are parallel to half a degree.
_NOT_AT_ALL = float(np.sin(0.5 * DEG))


def span_of(normals: Array) -> tuple[Array, Array]:
    """Return the singular values ``(3,)`` of unit normals ``(K, 3)``, the largest first and 0 for those missing, and their directions ``(3, 3)``."""
    _, values, directions = np.linalg.svd(normals)
    return np.append(values, np.zeros(3))[:3], directions


def unseen_directions(
    residuals: Residuals, model: Model, free: tuple[str, ...], covariance: Array
) -> dict[str, Any] | None:
    """Return the directions that the planes hardly show, with the uncertainty of predicted positions along them; None if there are none.

    The result has ``directions``, unit vectors in the base frame; ``seen``, the least singular value of the planes' normals, or 0; and
    ``std_along_m`` and ``std_across_m``, the standard error of predicted positions along these directions and along each of the others [m], root
    mean square over the measured poses, or None if the calibration has no covariance.

    Args:
        residuals: Of the dataset.
        model: Where the fit ended.
        free: Names of the F free parameters.
        covariance: ``(F, F)``.
    """
    planes = model.target
    if not isinstance(planes, Planes):
        return None
    values, directions = span_of(planes.normals)
    hidden = values < WEAK_SPAN
    if not hidden.any():
        return None
    found = pose_deviations(model, residuals.kinematics(model), free, covariance)
    along = across = None
    if found is not None:
        squares = np.mean(np.sum((directions @ found[:, :3]) ** 2, axis=2), axis=0)  # of each direction
        along, across = (float(np.sqrt(np.mean(squares[which]))) for which in (hidden, ~hidden))
    least = float(values[hidden][-1])
    return {
        "directions": [_readable(one) for one in directions[hidden]],
        "seen": least if least > _NOT_AT_ALL else 0.0,
        "std_along_m": along,
        "std_across_m": across,
    }


def check_one_plane(dataset: Dataset, model: Model) -> None:
    """Refuse planes of one direction that leave parameters to the data sheet while nobody states how exact it is.

    In 374 simulated workcells with one plane and without a tolerance, the 95 % ellipsoids of predicted positions held 95 % where no parameter was
    left to the data sheet, and 81 % where some were: one plane shows too little of the arm to estimate how far it is from its data sheet.

    Args:
        dataset: What was measured.
        model: The coarse fit, with the reasons of its priors.

    Raises:
        Undetermined: With the parameters.
    """
    planes, left = model.target, [prior.name for prior in model.priors if prior.reason]
    if not isinstance(planes, Planes) or dataset.robot.tolerance is not None or not left:
        return
    if span_of(planes.normals)[0][1] < WEAK_SPAN:
        raise Undetermined(
            f"planes of one direction alone leave {as_stated(', '.join(left), model.nominal)} to the data sheet, and how far the arm is from it "
            "cannot be estimated from them: state the maker's tolerance in dataset.yaml, as in robot.tolerance: {length: 5.0e-4, angle: 1.0e-3} "
            "[m, rad], or measure a plane that faces another way, or more poses that differ in all joints"
        )


def _readable(direction: Array) -> list[float]:
    """Return a direction with the sign that makes its largest component positive."""
    sign = np.sign(direction[np.argmax(np.abs(direction))])
    return [float(x) for x in sign * direction]
