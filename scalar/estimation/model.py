"""The model that is fitted: a robot, a sensor on its flange, a target and effects, with the coordinates of its parameters.

The coordinates are the robot's geometry, the sensor's translation, a rotation vector from the sensor's reference rotation, the target's
coordinates (of planes: tangents from their reference normals) and the effects' coefficients. Their names have the same order everywhere:
``a_1 .. beta_n, sensor_x .. sensor_rz, normal_<plane>_u .., <effect>.<coefficient>``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate

import numpy as np

from scalar.effects.effect import Effect
from scalar.effects.parameter_names import parameter_names
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array, exp_so3, log_so3, transform
from scalar.sensors import Target

_COMMON = frozenset({"names", "_geometry_names", "effect_names", "units", "blocks", "_prior_places"})
SENSOR_PARAMETERS = ("sensor_x", "sensor_y", "sensor_z", "sensor_rx", "sensor_ry", "sensor_rz")


@dataclass(frozen=True)
class ParameterPrior:
    """A Gaussian prior on one parameter, taken from the data sheet: one row ``(x - mean) / std`` of the residual.

    Attributes:
        name: Of the parameter.
        mean: Its value in the data sheet [m or rad].
        std: Prior standard deviation [m or rad].
        reason: A sentence if the prior rather than the data decides the parameter, else empty.
        held: Factor on ``std`` in fits; below 1 the parameter is held near the mean. Standard errors are computed without it (``Model.released``).
    """

    name: str
    mean: float
    std: float
    reason: str
    held: float = 1.0


@dataclass(frozen=True, eq=False)
class Model:
    """Robot, sensor, target and effects with definite values of all parameters.

    Attributes:
        robot: The arm, its geometry as estimated.
        nominal: The arm of the data sheet; the effects' columns are computed with it.
        reference_rotation: ``(3, 3)``, a rotation of the sensor on the flange from which its rotation vector is counted.
        sensor: ``(6,)``, translation [m] and rotation vector [rad] about the reference: ``R = exp(r) R_reference``.
        target: Planes or tracker frames.
        effects: With their coefficients.
        priors: Priors on parameters of robot and sensor; none if the data determine all of them well.
        misfit_ratio: Ratio of the residual to the noise by which its rows are whitened. The rows of priors are multiplied by it, so that what
            the model lacks counts as noise when data and priors are weighed against each other.
    """

    robot: Robot
    nominal: Robot
    reference_rotation: Array
    sensor: Array
    target: Target
    effects: tuple[Effect, ...] = ()
    priors: tuple[ParameterPrior, ...] = ()
    misfit_ratio: float = 1.0

    @classmethod
    def at(
        cls, nominal: Robot, T_flange_sensor: Array, target: Target, effects: Sequence[Effect] = ()
    ) -> Model:
        """Return the model of a nominal robot with a sensor at ``T_flange_sensor`` ``(4, 4)``."""
        sensor = _at_reference(T_flange_sensor[:3, 3])
        return cls(nominal, nominal, T_flange_sensor[:3, :3].copy(), sensor, target, tuple(effects))

    @cached_property
    def T_flange_sensor(self) -> Array:
        """Return the sensor's pose on the flange ``(4, 4)``; it is computed once and shared, and therefore read-only."""
        T = transform(exp_so3(self.sensor[3:]) @ self.reference_rotation, self.sensor[:3])
        T.setflags(write=False)
        return T

    @cached_property
    def names(self) -> list[str]:
        """Return the name of every coordinate."""
        return [*self._geometry_names, *(name for names in self.effect_names for name in names)]

    @cached_property
    def _geometry_names(self) -> list[str]:
        return [*self.robot.parameter_names, *SENSOR_PARAMETERS, *self.target.parameter_names]

    @cached_property
    def effect_names(self) -> list[tuple[str, ...]]:
        """Return for each effect the names of its coefficients; no two names of a model are the same."""
        return parameter_names(self.effects, self._geometry_names)

    @cached_property
    def units(self) -> list[str]:
        """Return the unit of every coordinate."""
        n = self.robot.n_joints
        geometry = ["m" if kind in LENGTHS else "rad" for kind in GEOMETRY for _ in range(n)]
        effects = [unit for effect in self.effects for unit in effect.coefficient_units]
        return [*geometry, "m", "m", "m", "rad", "rad", "rad", *self.target.parameter_units, *effects]

    @cached_property
    def blocks(self) -> dict[str, slice]:
        """Return where ``geometry``, ``sensor``, ``target`` and ``effects`` stand in the vector."""
        coefficients = sum(len(effect.coefficients) for effect in self.effects)
        sizes = {
            "geometry": self.robot.geometry.size,
            "sensor": len(self.sensor),
            "target": len(self.target.vector),
            "effects": coefficients,
        }
        ends = accumulate(sizes.values())
        return {name: slice(end - sizes[name], end) for name, end in zip(sizes, ends, strict=True)}

    @cached_property
    def _prior_places(self) -> tuple[Array, Array, Array]:
        """Return for each of P priors the index of its parameter, its mean, and its standard deviation in fits, ``(P,)`` each."""
        places = {name: i for i, name in enumerate(self.names)}
        index = np.array([places[prior.name] for prior in self.priors], dtype=int)
        means = np.array([prior.mean for prior in self.priors], dtype=float)
        return index, means, np.array([prior.std * prior.held for prior in self.priors], dtype=float)

    def prior_rows(self) -> tuple[Array, Array, Array]:
        """Return the residual rows of the k priors ``(k,)``, the indices of their coordinates ``(k,)``, and the derivatives by these ``(k,)``."""
        index, means, stds = self._prior_places
        slope = self.misfit_ratio / stds
        return (self.vector[index] - means) * self.misfit_ratio / stds, index, slope

    def differs_in_priors_alone(self, other: Model) -> bool:
        """Return whether another model has the same robot, sensor, target and effects, as objects: measured rows and kinematics are then the same."""
        return (
            self.robot is other.robot
            and self.sensor is other.sensor
            and self.target is other.target
            and self.effects is other.effects
            and self.reference_rotation is other.reference_rotation
            and self.nominal is other.nominal
        )

    @property
    def vector(self) -> Array:
        """Return the coordinates ``(P,)``, in the order of the names."""
        effects = [effect.coefficients for effect in self.effects]
        return np.concatenate([self.robot.geometry.ravel(), self.sensor, self.target.vector, *effects])

    def with_vector(self, vector: Array) -> Model:
        """Return the model at other coordinates ``(P,)`` about the same references."""
        blocks = self.blocks
        rest = vector[blocks["effects"]]
        effects = []
        for effect in self.effects:
            k = len(effect.coefficients)
            effects.append(effect.with_coefficients(rest[:k]))
            rest = rest[k:]
        model = replace(
            self,
            robot=self.robot.with_geometry(vector[blocks["geometry"]].reshape(len(GEOMETRY), -1)),
            sensor=np.array(vector[blocks["sensor"]]),
            target=self.target.with_vector(vector[blocks["target"]]),
            effects=tuple(effects),
        )
        return model._named_like(self)

    def _named_like(self, other: Model) -> Model:
        """Return this model after copying the cached names, units and positions in the vector from another model with the same parameters."""
        known = vars(other)
        vars(self).update((key, known[key]) for key in _COMMON & known.keys())
        return self

    def released(self) -> Model:
        """Return the model with no parameter held near the mean of its prior; the same object if none is."""
        if all(prior.held == 1.0 for prior in self.priors):
            return self
        return self.with_priors([replace(prior, held=1.0) for prior in self.priors], self.misfit_ratio)

    def with_priors(self, priors: Sequence[ParameterPrior], misfit_ratio: float) -> Model:
        """Return the model with other priors or another weight of them; what is known of its names and of the sensor's pose stays known."""
        model = replace(self, priors=tuple(priors), misfit_ratio=misfit_ratio)
        known = (_COMMON | {"T_flange_sensor"}) - {"_prior_places"}
        vars(model).update({key: value for key, value in vars(self).items() if key in known})
        return model

    def rebased(self) -> Model:
        """Return the same model with its current rotation and normals as references."""
        T = self.T_flange_sensor
        sensor = _at_reference(self.sensor[:3])
        model = replace(self, reference_rotation=T[:3, :3], sensor=sensor, target=self.target.rebased())
        return model._named_like(self)

    def sensor_rotation_vector(self) -> Array:
        """Return the absolute rotation vector ``(3,)`` [rad] of the sensor on the flange."""
        return log_so3(self.T_flange_sensor[:3, :3])


def _at_reference(translation: Array) -> Array:
    """Return the coordinates ``(6,)`` of a sensor at a translation ``(3,)`` [m] and at its reference rotation."""
    sensor = np.zeros(6)
    sensor[:3] = translation
    return sensor
