"""What the dataset declares before calibration: a nominal arm and initial guesses of the planes, both wrong on purpose.

An error is drawn for every parameter, and then set to zero for those that are to be exact, so that the errors of the
others do not depend on which are exact.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from scalar.simulation.config import ROBOT_PARAMETERS, parameter_names
from scalar.simulation.target_planes import TargetPlane
from scalar.simulation.transforms import Array
from scalar.units import DEG

SIGNS = (-1.0, 1.0)


def draw_errors(block: Mapping[str, Any], n: int, rng: np.random.Generator) -> dict[str, Array]:
    """Return Gaussian errors for `Arm.shifted`: a, d [m], alpha, theta, beta [rad] (n,); t, r (3,) [m, rad].

    Args:
        block: `length_std_m`, `angle_std_deg`, `beta_std_deg`, `sensor` and `exact` of the config.
        n: number of joints.
    """
    length, angle, beta = block["length_std_m"], block["angle_std_deg"] * DEG, block["beta_std_deg"] * DEG
    of_sensor = 1.0 if block["sensor"] else 0.0
    scale = np.repeat([length, length, angle, angle, beta], n)
    scale = np.concatenate([scale, np.repeat([of_sensor * length, of_sensor * angle], 3)])
    draws = rng.standard_normal(len(scale))
    exact = np.isin(parameter_names(n), block["exact"])
    errors = np.where(exact, 0.0, scale * draws)
    by_name = dict(zip(ROBOT_PARAMETERS, errors[: 5 * n].reshape(5, n), strict=True))
    return by_name | {"t": errors[5 * n : 5 * n + 3], "r": errors[5 * n + 3 :]}


def guess_plane(
    target_plane: TargetPlane, block: Mapping[str, float], rng: np.random.Generator
) -> dict[str, Any]:
    """Return the dataset's initial guess of a plane: `{name, normal, distance}`.

    The normal is tilted by `tilt_deg` in a drawn direction and by Gaussian angles about two axes; the
    distance n . p from the base's origin has an error of `offset_m` with a drawn sign and a Gaussian error. The tilt
    does not change the distance, so it turns the plane about the base's origin.

    Args:
        target_plane: the true plane.
        block: `tilt_deg`, `tilt_std_deg`, `offset_m` and `offset_std_m` of the config.
    """
    direction = rng.uniform(0.0, 2.0 * np.pi)
    sign = rng.choice(SIGNS)
    gaussian = rng.standard_normal(3)
    tilt = block["tilt_deg"] * DEG * np.array([np.cos(direction), np.sin(direction)])
    tilt = tilt + block["tilt_std_deg"] * DEG * gaussian[:2]
    angle = float(np.hypot(*tilt))
    in_face = target_plane.axes[:, :2] @ tilt / (angle or 1.0)
    normal = np.cos(angle) * target_plane.normal + np.sin(angle) * in_face
    distance = target_plane.distance + sign * block["offset_m"] + block["offset_std_m"] * gaussian[2]
    return {"name": target_plane.name, "normal": normal.tolist(), "distance": float(distance)}
