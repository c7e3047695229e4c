"""Whether positions that a tracker should have measured were computed from the joint angles: a controller displays and logs such positions.

They show nothing of the arm. Where all numbers have all decimals, a fit leaves less than any instrument does. Where they were rounded for the table,
or the positions logged a moment after the angles, something remains, but the data sheet explains the positions as well as the fit: with the base in
the frame of the positions, or in another one that the controller knows, and a tool that never changes. A real arm differs from its data sheet by
tenths of a millimetre at least, and no tracker stands in the frame of the base by itself.
"""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.suspicion import Suspicion
from scalar.estimation.setup.trial import nominal_fit
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.units import MM

COMPUTED = "computed"
# No instrument and arm leave a smaller residual: trackers scatter by 5 um at best, and arms by 10 um.
LEAST_MEASURED = 2e-3 * MM
ENOUGH_POSES = 20  # with fewer, a fit may leave hardly any residual because it has as many unknowns
NO_ARM = 0.03 * MM  # chosen: no arm is as near to its data sheet; arms repeat their poses to 0.02 to 0.1 mm
REPEATS = 0.01 * MM  # chosen: no arm repeats its poses so well
AS_WELL = 1.1  # ratio of what the data sheet leaves to what the fit leaves: with a smaller one, the fit has found nothing of the arm


def computed(dataset: Dataset, residual: float, *, rounded: bool) -> list[Suspicion]:
    """Return a suspicion if the positions of many poses were hardly measured.

    Args:
        dataset: What was measured.
        residual: Root mean square of what the fit leaves [m].
        rounded: Whether the joint angles are rounded so coarsely that this explains the residual.
    """
    if dataset.n_poses < ENOUGH_POSES:
        return []
    file, noise = kind_of(dataset).format.measured_in, dataset.sensor.noise
    if residual < LEAST_MEASURED and (noise is None or noise >= LEAST_MEASURED):
        reason = f"the residual is {residual / MM:.1g} mm, and no instrument measures so exactly, nor does any arm repeat its poses so well"
    elif (left := _left_by_arm_as_stated(dataset, residual, rounded=rounded)) is not None:
        because = ", which is what rounded joint angles leave" if rounded else ""
        reason = (
            f"the data sheet of the arm, with one tool and in the frame of {file} or one turned against it, explains the positions as well as the "
            f"fit does ({left / MM:.2g} and {residual / MM:.2g} mm{because}), and no real arm and tracker agree so with a data sheet"
        )
    else:
        return []
    return [
        Suspicion(
            COMPUTED,
            file,
            f"{reason}: were the positions of {file} computed from the joint angles (the commanded or displayed position of the controller, a "
            "simulation)? Then they show nothing of the arm; put in what was measured",
        )
    ]


def _left_by_arm_as_stated(dataset: Dataset, residual: float, *, rounded: bool) -> float | None:
    """Return what the arm of the data sheet leaves of tracked points [m], if it is no more than the fit leaves and than computed positions may have.

    Args:
        dataset: What was measured.
        residual: Root mean square of what the fit leaves [m].
        rounded: Whether the joint angles are rounded so coarsely that this explains the residual.
    """
    if not kind_of(dataset).measures_positions:
        return None
    left = _left_by_data_sheet(dataset)
    if left is not None and left <= AS_WELL * residual and (rounded or left < NO_ARM):
        return left
    if residual < REPEATS and (left := nominal_fit(dataset).of_all) <= min(AS_WELL * residual, REPEATS):
        return left
    return None


def _left_by_data_sheet(dataset: Dataset) -> float | None:
    """Return the root mean square distance [m] of tracked points from those of the nominal arm; None unless there is one point for each pose.

    The arm stands in the frame of the points. The place of the target on the flange alone is fitted: the mean of where the flange sees the points.
    """
    points = dataset.points
    if points.shape != (dataset.n_poses, 3):
        return None
    return float(np.sqrt(np.mean(np.sum(_off_nominal(dataset.robot, dataset.q, points) ** 2, axis=1))))


def _off_nominal(robot: Robot, q: Array, points: Array) -> Array:
    """Return where points ``(N, 3)`` are, seen from the flange of the nominal arm, from their mean there, ``(N, 3)`` [m]."""
    T = robot.flange(q)
    seen = np.einsum("nji,nj->ni", T[:, :3, :3], points - T[:, :3, 3])
    return seen - seen.mean(axis=0)
