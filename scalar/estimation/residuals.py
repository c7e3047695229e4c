"""The whitened residual of a model on a dataset, its signed components, and its analytic Jacobian.

The rows of the sensor (``scalar.sensors``) come first, pose by pose, then those of prior information: planes that the user declared ``known``,
prior standard deviations of effects, priors on parameters. The derivative of a row by a coordinate is the row's wrench (its derivative by a
motion of the sensor) times the coordinate's screw (that motion's derivative by the coordinate).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import is_
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.poses import Poses
from scalar.effects import Effect, PointEffect
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.estimation.normal_equations import NormalEquations
from scalar.estimation.reference_planes import ReferencePlanes
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.kernels import LIBRARY
from scalar.kernels.plane_problem import PlaneProblem
from scalar.sensors import Measurement, Rows, by_coordinates, measure

_MOST_KEPT = 32_000_000  # bytes; a larger Jacobian (of thousands of poses) is not kept, but computed anew


@dataclass(frozen=True, eq=False)
class BoundPointEffect:
    """An effect on points or surfaces, with the poses at which it acts."""

    effect: PointEffect
    poses: Poses

    @property
    def basis_names(self) -> tuple[str, ...]:
        """Return the names of the functions of the points that the effect adds."""
        return self.effect.basis_names

    @property
    def coefficients(self) -> Array:
        """Return the coefficients ``(k,)`` of the effect."""
        return self.effect.coefficients

    def constant_and_shares(self) -> tuple[str, BoundPointEffect, Array] | None:
        """Return a key of the effect that acts alike at all poses, this effect, and its shares ``(N,)``; None if there is none (``PointEffect``)."""
        return self._constant_and_shares

    @cached_property
    def _constant_and_shares(self) -> tuple[str, BoundPointEffect, Array] | None:
        """Return what ``constant_and_shares`` returns, computed once."""
        found = self.effect.constant_and_shares(self.poses)
        if found is None:
            return None
        return (
            f"{type(found[0]).__name__} {found[0].to_mapping()}",
            BoundPointEffect(found[0], self.poses),
            found[1],
        )

    def contact_columns(self, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array) -> Array:
        """Return the effect's columns at its poses; arguments and result are those of ``PointEffect.contact_columns``."""
        return self.effect.contact_columns(self.poses, T_base_sensor, planes, plane_index, contact)


@dataclass(eq=False)
class Residuals:
    """A dataset and the effects of a model, ready to be evaluated for any values of the model's parameters.

    Attributes:
        measurement: The whitened rows.
        poses: What is known of each pose.
        bases: The columns of the effects.
        known: Rows of reference planes, or None.
    """

    measurement: Measurement
    poses: Poses
    bases: EffectBases
    known: ReferencePlanes | None
    _latest: tuple[Model, Kinematics, Rows] | None = field(default=None, init=False, repr=False)
    _kinematics: Kinematics | None = field(default=None, init=False, repr=False)
    _linearised: tuple[Model, Array, Array] | None = field(default=None, init=False, repr=False)
    _normal: tuple[Model, Array, NormalEquations] | None = field(default=None, init=False, repr=False)
    _problem: tuple[tuple[Any, ...], PlaneProblem | None] | None = field(default=None, init=False, repr=False)

    @classmethod
    def of(cls, dataset: Dataset, model: Model, measurement: Measurement | None = None) -> Residuals:
        """Return the residuals of a dataset for models with the effects of ``model``.

        Args:
            dataset: What was measured.
            model: Gives the nominal robot, the target's names and the effects.
            measurement: The dataset already reduced to rows, or None.
        """
        poses = dataset.known_poses
        if measurement is None:
            measurement = measure(dataset, extra_basis_of(model.effects))
        bases = EffectBases.of(model.nominal, poses, model.effects)
        return cls(measurement, poses, bases, ReferencePlanes.of(dataset, model.target))

    def kinematics(self, model: Model) -> Kinematics:
        """Return the kinematics of a model at every pose of the dataset."""
        if self._kinematics is None or not self._kinematics.model.differs_in_priors_alone(model):
            self._kinematics = Kinematics.of(model, self.poses, self.bases)
        return self._kinematics

    def point_effects(self, model: Model) -> list[BoundPointEffect]:
        """Return the model's effects on points and surfaces, bound to the poses."""
        return [
            BoundPointEffect(effect, self.poses)
            for effect in model.effects
            if isinstance(effect, PointEffect)
        ]

    def _at(self, model: Model) -> tuple[Kinematics, Rows]:
        """Return kinematics and rows at a model; they are kept, since a fit asks for the Jacobian where it asked for the residual."""
        if self._latest is None or not self._latest[0].differs_in_priors_alone(model):
            kinematics = self.kinematics(model)
            rows = self.measurement.rows(kinematics.T_base_sensor, model.target, self.point_effects(model))
            self._latest = model, kinematics, rows
        return self._latest[1], self._latest[2]

    def plane_problem(self, model: Model) -> PlaneProblem | None:
        """Return the measured rows as a problem of the compiled library, for all models about the same references; None where it does not apply.

        It is kept, since most models that are asked for in turn share their references.
        """
        robot, tangents = model.robot, getattr(model.target, "tangents", None)
        references = (
            LIBRARY, robot.T_base_0, robot.T_n_flange, model.reference_rotation, tangents, model.effects,
        )  # fmt: skip
        if self._problem is None or not all(map(is_, references, self._problem[0])):
            index, factors = self.measurement.target_index, self.measurement.contact_factors
            problem = None if factors is None else plane_problem(model, self.poses, index, factors)
            self._problem = references, problem
        return self._problem[1]

    def wrench(self, model: Model) -> Array:
        """Return the derivatives ``(N, m, 6)`` of the measured rows by a motion of the sensor, a screw in the base frame."""
        return self._at(model)[1].wrench

    def residual(self, model: Model) -> Array:
        """Return all rows ``(N m + priors,)``, in standard deviations."""
        return np.concatenate([self._measured(model).ravel(), self._priors(model)[0]])

    def _measured(self, model: Model) -> Array:
        """Return the measured rows alone, ``(N m,)`` or ``(N, m)``."""
        if self._linearised is not None and self._linearised[0].differs_in_priors_alone(model):
            return self._linearised[1]
        problem = self.plane_problem(model)
        return self._at(model)[1].residual if problem is None else problem.residual(model.vector)

    def linearise(self, model: Model) -> tuple[Array, Array]:
        """Return all rows and their Jacobian ``(N m + priors, P)`` by the coordinates of ``Model.names``."""
        residual, jacobian = self.linearise_measured(model)
        prior, below = self._priors(model)
        if not len(prior):
            return residual, jacobian
        return np.concatenate([residual, prior]), np.vstack([jacobian, below])

    def linearise_measured(self, model: Model) -> tuple[Array, Array]:
        """Return the measured rows alone, ``(N m,)`` and ``(N m, P)``, both read-only; they are kept until another model is asked for."""
        if self._linearised is not None and self._linearised[0].differs_in_priors_alone(model):
            return self._linearised[1:]
        residual, jacobian = self._linearise_measured(model)
        residual.flags.writeable = jacobian.flags.writeable = False
        if jacobian.nbytes <= _MOST_KEPT:
            self._linearised = model, residual, jacobian
        return residual, jacobian

    def _linearise_measured(self, model: Model) -> tuple[Array, Array]:
        """Return what ``linearise_measured`` returns, computed anew."""
        problem = self.plane_problem(model)
        if problem is not None:
            values, jacobian = problem.linearise(model.vector)
            return values.ravel(), jacobian.reshape(values.size, -1)
        kinematics, rows = self._at(model)
        N, m = rows.residual.shape
        # The columns of effects on joints are multiples of the derivatives by theta (or d): cheaper than by their screws.
        jacobian = rows.wrench @ kinematics.screws(joint_effects=False)
        blocks = model.blocks
        at = blocks["target"]
        if rows.target.shape[2]:  # a target that is known has no coordinates
            jacobian[:, :, at] = by_coordinates(model.target, rows.target, self.measurement.target_index)
        start = blocks["effects"].start
        by_joint = jacobian[:, :, model.robot.joint_columns]
        for basis, where in self.bases.joints:
            jacobian[:, :, start + where.start : start + where.stop] = basis.columns(by_joint)
        done = 0
        for effect in model.effects:
            k = len(effect.coefficients)
            if isinstance(effect, PointEffect):
                jacobian[:, :, start : start + k] = rows.extra[:, :, done : done + k]
                done += k
            start += k
        return rows.residual.ravel(), jacobian.reshape(N * m, -1)

    def normal_equations(self, model: Model, free: Array) -> NormalEquations:
        """Return the normal equations of all rows but those of priors on parameters by the free coordinates ``(P,)`` bool; the latest are kept."""
        if (
            self._normal is not None
            and self._normal[0].differs_in_priors_alone(model)
            and np.array_equal(self._normal[1], free)
        ):
            return self._normal[2]
        problem = None if self.known is not None else self.plane_problem(model)
        if problem is None:
            residual, jacobian = self.linearise(model.with_priors((), 1.0))
            found = NormalEquations.of(residual, jacobian[:, np.flatnonzero(free)])
        else:
            N, m, _ = problem.shape
            found = NormalEquations(*problem.normal_equations(model.vector, np.flatnonzero(free)), N * m)
        self._normal = model, free, found
        return found

    def _priors(self, model: Model) -> tuple[Array, Array]:
        """Return the rows of prior information ``(k,)`` and their Jacobian ``(k, P)``: reference planes, effects' priors, priors on parameters."""
        blocks = model.blocks
        if (
            self.known is None and not model.effects and not model.priors
        ):  # as in most fits, which are spared the calls below at each step
            return np.zeros(0), np.zeros((0, blocks["effects"].stop))
        vector = model.vector
        coefficients = vector[blocks["effects"]]
        sizes = np.concatenate([np.zeros(0), *(effect.prior_std for effect in model.effects)])
        known = np.zeros(0) if self.known is None else self.known.rows(model.target)[0]  # type: ignore[arg-type]
        bounded = np.isfinite(sizes)
        n_bounded = len(known) + int(bounded.sum())
        below = np.zeros((n_bounded + len(model.priors), blocks["effects"].stop))
        if self.known is not None:
            below[: len(known), blocks["target"]] = self.known.rows(model.target)[1]  # type: ignore[arg-type]
        columns = blocks["effects"].start + np.flatnonzero(bounded)
        below[np.arange(len(known), n_bounded), columns] = 1.0 / sizes[bounded]
        off, index, slope = model.prior_rows()
        below[np.arange(n_bounded, len(below)), index] = slope
        return np.concatenate([known, coefficients[bounded] / sizes[bounded], off]), below

    def reweighted(self, model: Model) -> Residuals:
        """Return the same residuals, their weights computed anew at a model: from the incidence of rays, or from a noise that is estimated."""
        kinematics = self.kinematics(model)
        return self.measured_as(self.measurement.reweighted(kinematics.T_base_sensor, model.target), model)

    def measured_as(self, measurement: Measurement, model: Model) -> Residuals:
        """Return the residuals of the same poses with other rows of their measurements; the kinematics of a model are known to both."""
        found = Residuals(measurement, self.poses, self.bases, self.known)
        found._kinematics = self.kinematics(model)
        return found

    def rms(self, model: Model) -> float:
        """Return the root mean square distance of points and target [m], unweighted."""
        squares, counts = self.squared_distances(model)
        return float(np.sqrt(squares.sum() / counts.sum()))

    def squared_distances(self, model: Model) -> tuple[Array, Array]:
        """Return for every pose the sum of the squared distances of its points from the target ``(N,)`` [m^2], and their number ``(N,)``."""
        T = self.kinematics(model).T_base_sensor
        return self.measurement.distances(T, model.target, self.point_effects(model))

    def pose_distances(self, model: Model) -> Array:
        """Return the root mean square distance of every pose from its target ``(N,)`` [m], effects applied."""
        squares, counts = self.squared_distances(model)
        return np.sqrt(squares / counts)


def plane_problem(model: Model, poses: Poses, index: Array, factors: Array) -> PlaneProblem | None:
    """Return rows ``factors @ c``, c the contact vectors (defined at ``PlaneProblem``), as a problem of the compiled library.

    None is returned without the library, and for what it does not support: targets other than planes, prismatic joints, effects.

    Args:
        model: Gives what does not change with the coordinates: fixed transforms and references.
        poses: With joint angles ``(N, n)`` [rad].
        index: ``(N,)``, which plane each pose measures.
        factors: ``(N, m, 3)``.
    """
    target = model.target
    if LIBRARY is None or model.effects or model.robot.prismatic or not isinstance(target, Planes):
        return None
    fixed = model.robot.T_base_0, model.robot.T_n_flange, model.reference_rotation
    return PlaneProblem(poses.turned, index, factors, *fixed, target.reference_normals, target.tangents)


def extra_basis_of(effects: Sequence[Effect]) -> tuple[str, ...]:
    """Return the functions of a point that the effects need kept in the compressed scans."""
    return tuple(name for effect in effects if isinstance(effect, PointEffect) for name in effect.basis_names)
