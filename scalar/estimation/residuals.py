"""The whitened residual of a model on a dataset, its signed components, and its analytic Jacobian.

Rows are those of the sensor (``scalar.sensors``), pose by pose, then the rows of what is known beforehand: planes that the user declared
``known``. A row's derivative is its wrench times the screw of every coordinate, so no derivative is ever taken through a chain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import Effect, PointEffect
from scalar.estimation.model import EffectBases, Kinematics, Model
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors import Measurement, Rows, measure

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class BoundPointEffect:
    """An effect on points or surfaces, with the poses at which it acts."""

    effect: PointEffect
    poses: Poses

    @property
    def basis_names(self) -> tuple[str, ...]:
        """Functions of the points that the effect adds."""
        return self.effect.basis_names

    @property
    def coefficients(self) -> Array:
        """Coefficients ``(k,)`` of the effect."""
        return self.effect.coefficients

    def contact_columns(self, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array) -> Array:
        """Return the effect's columns at its poses."""
        return self.effect.contact_columns(self.poses, T_base_sensor, planes, plane_index, contact)


@dataclass(frozen=True, eq=False)
class Known:
    """Rows for planes that are references: the tilt and the distance stay near what was declared.

    Attributes:
        index: ``(k,)``, which planes of the target.
        normals, distances: As declared, ``(k, 3)`` and ``(k,)`` [m].
        normal_std, distance_std: ``(k,)`` [rad] and [m]; infinite where not declared.
    """

    index: Array
    normals: Array
    distances: Array
    normal_std: Array
    distance_std: Array

    @classmethod
    def of(cls, dataset: Dataset, target: Any) -> Known | None:
        """Return what the dataset declares known of its planes, or None."""
        if not isinstance(target, Planes):
            return None
        by_name = {plane.name: plane for plane in dataset.planes}
        found = []
        for k, name in enumerate(target.names):
            plane = by_name[name.split("@")[0] if name not in by_name else name]
            if plane.normal_std is not None or plane.distance_std is not None:
                found.append((k, plane))
        if not found:
            return None

        def column(values: Sequence[float | None]) -> Array:
            return np.array([np.inf if value is None else value for value in values])

        return cls(
            np.array([k for k, _ in found]),
            np.array([plane.normal for _, plane in found]),
            np.array([plane.distance for _, plane in found]),
            column([plane.normal_std for _, plane in found]),
            column([plane.distance_std for _, plane in found]),
        )

    def rows(self, planes: Planes) -> tuple[Array, Array]:
        """Return the rows ``(4 k,)`` and their derivatives by the planes' coordinates ``(4 k, 3 K)``."""
        count = len(self.index)
        delta = (planes.normals[self.index] - self.normals) / self.normal_std[:, None]
        residual = np.concatenate(
            [delta.ravel(), (planes.distances[self.index] - self.distances) / self.distance_std]
        )
        jacobian = np.zeros((4 * count, len(planes.vector)))
        by_tangent = planes.normal_derivatives[self.index] / self.normal_std[:, None, None]
        for i, k in enumerate(self.index):
            jacobian[3 * i : 3 * i + 3, 3 * k : 3 * k + 2] = by_tangent[i]
            jacobian[3 * count + i, 3 * k + 2] = 1.0 / self.distance_std[i]
        return residual, jacobian


@dataclass(eq=False)
class Residuals:
    """A dataset and the effects of a model, ready to be evaluated at any point of the model.

    Attributes:
        measurement: The whitened rows.
        poses: What is known of each pose.
        bases: The columns of the effects.
        known: Rows of reference planes, or None.
    """

    measurement: Measurement
    poses: Poses
    bases: EffectBases
    known: Known | None
    _latest: tuple[Model, Kinematics, Rows] | None = field(default=None, init=False, repr=False)

    @classmethod
    def of(cls, dataset: Dataset, model: Model, measurement: Measurement | None = None) -> Residuals:
        """Return the residuals of a dataset for models with the effects of ``model``.

        Args:
            dataset: What was measured.
            model: Gives the nominal robot, the target's names and the effects.
            measurement: The dataset already reduced to rows, or None.
        """
        poses = Poses.from_frame(dataset.poses, dataset.robot.n_joints, order_is_row=True)
        if measurement is None:
            measurement = measure(dataset, extra_basis_of(model.effects))
        bases = EffectBases.of(model.nominal, poses, model.effects)
        return cls(measurement, poses, bases, Known.of(dataset, model.target))

    def kinematics(self, model: Model) -> Kinematics:
        """Return where the sensor is at every pose."""
        return Kinematics.of(model, self.poses, self.bases)

    def point_effects(self, model: Model) -> list[BoundPointEffect]:
        """Return the model's effects on points and surfaces, bound to the poses."""
        return [
            BoundPointEffect(effect, self.poses)
            for effect in model.effects
            if isinstance(effect, PointEffect)
        ]

    def _at(self, model: Model) -> tuple[Kinematics, Rows]:
        """Return kinematics and rows at a model, kept since a Jacobian follows a residual at the same object."""
        if self._latest is None or self._latest[0] is not model:
            kinematics = self.kinematics(model)
            rows = self.measurement.rows(kinematics.T_base_sensor, model.target, self.point_effects(model))
            self._latest = model, kinematics, rows
        return self._latest[1], self._latest[2]

    def residual(self, model: Model) -> Array:
        """Return all rows ``(N m + priors,)``, in standard deviations."""
        return np.concatenate([self._at(model)[1].residual.ravel(), self._priors(model)[0]])

    def linearise(self, model: Model) -> tuple[Array, Array]:
        """Return all rows and their Jacobian ``(N m + priors, P)`` by the coordinates of ``Model.names``."""
        residual, jacobian = self.linearise_measured(model)
        prior, below = self._priors(model)
        if not len(prior):
            return residual, jacobian
        return np.concatenate([residual, prior]), np.vstack([jacobian, below])

    def linearise_measured(self, model: Model) -> tuple[Array, Array]:
        """Return the measured rows alone, ``(N m,)`` and ``(N m, P)``."""
        kinematics, rows = self._at(model)
        N, m = rows.residual.shape
        # Effects on joints multiply the derivatives by the angles, which stand at theta: m columns each instead of six.
        jacobian = rows.wrench @ kinematics.screws(joint_effects=False)
        blocks = model.blocks
        items = jacobian[:, :, blocks["target"]].reshape(N, m, -1, rows.target.shape[2])
        items[np.arange(N), :, self.measurement.target_index] = rows.target
        start, n = blocks["effects"].start, model.robot.n_joints
        by_angle = jacobian[:, :, 3 * n : 4 * n]
        for basis, where in self.bases.joints:
            jacobian[:, :, start + where.start : start + where.stop] = basis.columns(by_angle)
        done = 0
        for effect in model.effects:
            k = len(effect.coefficients)
            if isinstance(effect, PointEffect):
                jacobian[:, :, start : start + k] = rows.extra[:, :, done : done + k]
                done += k
            start += k
        jacobian[:, :, blocks["target"]] = items.reshape(N, m, -1)
        return rows.residual.ravel(), jacobian.reshape(N * m, -1)

    def _priors(self, model: Model) -> tuple[Array, Array]:
        """Return the rows of what is known beforehand and their Jacobian: reference planes, how large effects may be, anchors."""
        blocks = model.blocks
        if (
            self.known is None and not model.effects and not model.anchors
        ):  # most fits: not worth the dozen calls below at each step
            return np.zeros(0), np.zeros((0, blocks["effects"].stop))
        coefficients = model.vector[blocks["effects"]]
        sizes = np.concatenate([np.zeros(0), *(effect.plausible_sizes for effect in model.effects)])
        known = np.zeros(0) if self.known is None else self.known.rows(model.target)[0]  # type: ignore[arg-type]
        bounded = np.isfinite(sizes)
        n_bounded = len(known) + int(bounded.sum())
        below = np.zeros((n_bounded + len(model.anchors), blocks["effects"].stop))
        if self.known is not None:
            below[: len(known), blocks["target"]] = self.known.rows(model.target)[1]  # type: ignore[arg-type]
        columns = blocks["effects"].start + np.flatnonzero(bounded)
        below[np.arange(len(known), n_bounded), columns] = 1.0 / sizes[bounded]
        off = np.zeros(len(model.anchors))
        for k, anchor in enumerate(model.anchors):
            i = model.names.index(anchor.name)
            below[n_bounded + k, i] = 1.0 / anchor.std
            off[k] = (model.vector[i] - anchor.value) / anchor.std
        return np.concatenate([known, coefficients[bounded] / sizes[bounded], off]), below

    def reweighted(self, model: Model) -> Residuals:
        """Return the same residuals, whitened for the geometry of the estimate."""
        T = self.kinematics(model).T_base_sensor
        return Residuals(self.measurement.reweighted(T, model.target), self.poses, self.bases, self.known)

    def rms(self, model: Model) -> float:
        """Return the root mean square distance of points and target [m], unweighted."""
        squares, counts = self.squared_distances(model)
        return float(np.sqrt(squares.sum() / counts.sum()))

    def squared_distances(self, model: Model) -> tuple[Array, Array]:
        """Return per pose the sum of squared distances [m^2] and their number."""
        T = self.kinematics(model).T_base_sensor
        return self.measurement.distances(T, model.target, self.point_effects(model))


def extra_basis_of(effects: Sequence[Effect]) -> tuple[str, ...]:
    """Return the functions of a point that the effects need kept in the compressed scans."""
    return tuple(name for effect in effects if isinstance(effect, PointEffect) for name in effect.basis_names)
