"""What a measurement is reduced to: whitened residual rows with their derivatives, and pieces of scans for pictures.

The rows of a pose depend on the robot only through the pose of the sensor, so a row's derivative is a wrench ``(1, 6)``: a small screw (w, v)
of the sensor, in the base frame, changes the residual by ``wrench . (w, v)``.
"""

from __future__ import annotations

from dataclasses import dataclass

from scalar.geometry.se3 import Array

UNSTATED_SIGMA = 1e-4  # m; assumed if no noise is stated, until (for some kinds) it is estimated from scatter
# Least noise [m]: no sensor has less, and rounding errors of coordinates in metres are far smaller.
LEAST_SIGMA = 1e-9


def stated_sigma(noise: float | None) -> float:
    """Return the standard deviation [m] with which rows are whitened if a dataset states ``noise`` [m] or None."""
    return UNSTATED_SIGMA if noise is None else max(float(noise), LEAST_SIGMA)


@dataclass(frozen=True)
class UsualNoise:
    """By how much instruments of a kind scatter, for a user who states no noise; it enters no computation.

    Data sheets state 15 um + 6 um/m for laser trackers and 1 to 2 um for touch-trigger probes.

    Attributes:
        words: A clause with sizes, from data sheets.
        most: [m], beyond which neither the instrument nor the arm's repeatability (ISO 9283: 0.02 to 0.1 mm) explains a residual.
    """

    words: str
    most: float


@dataclass(frozen=True, eq=False)
class Rows:
    """Whitened residual rows of N poses, m each, and their derivatives.

    Attributes:
        residual: ``(N, m)``, in standard deviations.
        wrench: ``(N, m, 6)``, derivative by a screw of the sensor in the base frame [1/rad, 1/m].
        target: ``(N, m, t + common)``, derivative by the coordinates of the pose's own target item, then by those that all items share.
        extra: ``(N, m, k)``, derivative by the coefficients of effects on points and surfaces.
    """

    residual: Array
    wrench: Array
    target: Array
    extra: Array


@dataclass(frozen=True, eq=False)
class Pieces:
    """P pieces of measurements on planes; the points of a piece are averaged.

    Attributes:
        pose: ``(P,)``, index of the pose.
        reach: ``(P,)`` [m], measured range, or z if the sensor errs along z.
        position: ``(P, 3)`` [m], base frame.
        height: ``(P,)`` [m], over the plane, with all effects applied.
        of_effect: ``(P,)`` [m], the part of the height from one effect.
        incidence: ``(P,)``, ``n . e``: by how much the height grows with the range.
        std: ``(P,)`` [m], standard error of the height.
        profile: ``(P, 2)`` [m], x and z in the scanner's plane; empty for a sensor without one.
    """

    pose: Array
    reach: Array
    position: Array
    height: Array
    of_effect: Array
    incidence: Array
    std: Array
    profile: Array
