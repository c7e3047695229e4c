"""The parameters of the original paper's model as printed: every unit vector is three numbers, the third a square root of the others.

An arm has four parameters for each joint, the sensor seven and each plane four. One of the sensor's and one of each plane's is constrained by
``n_z = sqrt(1 - n_x^2 - n_y^2)``. The normal of an upright wall has n_z = 0, where the slope of the root is infinite and next to which the root is
undefined. The paper does not say how it treated that. The possible readings of the root's argument have names: ``raise`` leaves it as it is, so
that lmfit stops at the first NaN; ``clip`` takes max(0, .); ``abs`` takes the absolute value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scalar.estimation.lmfit_parameters import lmfit_names
from scalar.estimation.model import Model
from scalar.estimation.reporting import reporting
from scalar.geometry.planes import Planes
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.se3 import Array, exp_so3, transform

if TYPE_CHECKING:
    import lmfit

READINGS = {"raise": "sqrt({})", "clip": "sqrt(max(0, {}))", "abs": "sqrt(abs({}))"}
"""The square root of the constraints in each reading, as an lmfit expression of its argument."""
DH_KINDS = GEOMETRY[:4]  # the published model has no beta
SENSOR = ("r_x", "r_y", "r_z", "r_theta", "sensor_x", "sensor_y", "sensor_z")


@dataclass(frozen=True, eq=False)
class Parameterisation:
    """The published parameters of a robot, its scanner and its planes: from a model to their values, and back.

    Attributes:
        nominal: The arm of the data sheet; its beta is kept.
        planes: The initial guesses; a plane is reported with the sign of its guess.
    """

    nominal: Robot
    planes: Planes

    @property
    def names(self) -> list[str]:
        """Return ``a_1 .. theta_n r_x .. sensor_z normal_<plane>_x .. distance_<plane>``, the order of all values [m, rad]."""
        geometry = [f"{kind}_{i + 1}" for kind in DH_KINDS for i in range(self.nominal.n_joints)]
        planes = [
            text
            for name in self.planes.names
            for text in (*(f"normal_{name}_{axis}" for axis in "xyz"), f"distance_{name}")
        ]
        return [*geometry, *SENSOR, *planes]

    def values(self, T_flange_sensor: Array) -> Array:
        """Return the parameters ``(P,)`` of the nominal arm, the guessed planes and a scanner at ``T_flange_sensor`` ``(4, 4)``.

        The root is never negative, so a normal or a rotation axis with a negative third component is reversed, together with its
        distance or angle. The angle then lies between -pi and pi; the fit sets no bound on it.
        """
        rotation_vector = Model.at(self.nominal, T_flange_sensor, self.planes).sensor_rotation_vector()
        angle = float(np.linalg.norm(rotation_vector))
        axis = rotation_vector / angle if angle > 0 else np.array([0.0, 0.0, 1.0])
        turn = -1.0 if axis[2] < 0 else 1.0
        side = np.where(self.planes.normals[:, 2:] < 0, -1.0, 1.0)
        planes = side * np.column_stack([self.planes.normals, self.planes.distances])
        geometry = self.nominal.geometry[: len(DH_KINDS)].ravel()
        return np.concatenate([geometry, turn * axis, [turn * angle], T_flange_sensor[:3, 3], planes.ravel()])

    def lmfit_parameters(self, values: Array, fixed: Sequence[str], reading: str) -> lmfit.Parameters:
        """Return lmfit parameters at values ``(P,)``, with the third component of every unit vector constrained.

        Args:
            values: ``(P,)`` [m, rad], in the order of ``names``.
            fixed: Names of the parameters that do not vary.
            reading: A key of ``READINGS``.
        """
        import lmfit

        parameters = lmfit.Parameters()
        safe = dict(zip(self.names, lmfit_names(self.names), strict=True))
        for name, value in zip(self.names, values, strict=True):
            parameters.add(safe[name], value=float(value), vary=name not in fixed)
        for stem in ("r", *(f"normal_{name}" for name in self.planes.names)):
            x, y = safe[f"{stem}_x"], safe[f"{stem}_y"]
            parameters[safe[f"{stem}_z"]].expr = READINGS[reading].format(f"1 - {x}**2 - {y}**2")
        return parameters

    def unpack(self, values: Array) -> tuple[Robot, Array, Array, Array]:
        """Return the arm, ``T_flange_sensor`` ``(4, 4)``, normals ``(K, 3)`` and distances ``(K,)`` [m] of values ``(P,)``.

        The normals are unit vectors only as far as the values meet the constraints; with the reading ``abs``, for example, they may be longer.
        """
        n = self.nominal.n_joints
        geometry, sensor, planes = np.split(values, [len(DH_KINDS) * n, len(DH_KINDS) * n + len(SENSOR)])
        beta = self.nominal.geometry[len(DH_KINDS) :]
        robot = self.nominal.with_geometry(np.vstack([geometry.reshape(-1, n), beta]))
        axis = sensor[:3] / np.linalg.norm(sensor[:3])
        table = planes.reshape(-1, 4)
        return robot, transform(exp_so3(axis * sensor[3]), sensor[4:]), table[:, :3], table[:, 3]

    def model(self, values: Array) -> Model:
        """Return the model of values ``(P,)`` in reporting coordinates; a plane's sign is that of its initial guess."""
        robot, T_flange_sensor, normals, distances = self.unpack(values)
        sign = np.where(np.sum(normals * self.planes.normals, axis=1) < 0, -1.0, 1.0)
        scale = sign / np.linalg.norm(normals, axis=1)
        target = Planes.at(self.planes.names, normals * scale[:, None], distances * scale)
        sensor = np.r_[T_flange_sensor[:3, 3], 0.0, 0.0, 0.0]
        return reporting(Model(robot, self.nominal, T_flange_sensor[:3, :3], sensor, target), self.planes)
