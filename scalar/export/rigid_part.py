"""The rigid arm within a calibrated model: what a description by fixed transforms can hold, and how large the rest is.

An effect that adds the same at every pose (a tilted axis, a sensor that has slipped and stays there) is included in the geometry. The
other effects change from pose to pose and are left out; the size of each is how far it moves the sensor at random poses within the joint
limits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scalar.data.poses import Poses
from scalar.effects import Effect, PointEffect
from scalar.errors import InvalidInput
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.geometry.robot import Robot
from scalar.geometry.screws import exp_screw
from scalar.geometry.se3 import Array

SAMPLES = 1000
"""Number of random poses at which the sizes of effects are computed and files are compared with the model."""
_SAMPLE_SEED = 0
_SAME = 1e-12  # m or rad: what an effect adds is taken to be the same at all poses if it varies by no more than this


@dataclass(frozen=True)
class LeftOut:
    """An effect that a rigid description cannot hold.

    Attributes:
        effect: The effect.
        rms: Root mean square of how far it moves the sensor at random poses [m]; None if a column that the effect needs is not given.
        largest: The largest such distance [m]; None in the same case.
        missing: Name of the column that is not given, or None.
    """

    effect: Effect
    rms: float | None
    largest: float | None
    missing: str | None


@dataclass(frozen=True, eq=False)
class RigidPart:
    """The rigid arm of a model.

    Attributes:
        robot: The calibrated robot; its geometry includes the effects that are the same at every pose.
        T_flange_sensor: ``(4, 4)``, the sensor on the flange, which includes them likewise.
        included: The effects that are the same at every pose.
        added_by: For each of their coefficients, by its name in the model, ``(5, n)``: what one unit of it adds to the geometry.
        left_out: The effects that are not.
        rms: Root mean square of how far all effects left out move the sensor together [m], without those whose column is missing.
        largest: The largest such distance [m].
    """

    robot: Robot
    T_flange_sensor: Array
    included: tuple[Effect, ...]
    added_by: Mapping[str, Array]
    left_out: tuple[LeftOut, ...]
    rms: float
    largest: float


def random_joints(robot: Robot) -> Array:
    """Return joint positions ``(SAMPLES, n)`` [rad; m for a prismatic joint], uniform within the limits, the same at every call."""
    rng = np.random.default_rng(_SAMPLE_SEED)
    low, high = robot.limits.T
    return rng.uniform(low, high, (SAMPLES, robot.n_joints))


def rigid_part(model: Model, columns: Mapping[str, float]) -> RigidPart:
    """Return the rigid arm of a model, with the effects that it leaves out.

    Args:
        model: The calibrated model.
        columns: Values of columns of poses.csv, by name, which hold at every pose. Directions of approach are random, and the poses come
            after all measured ones in the order of acquisition.
    """
    q = random_joints(model.nominal)
    rng = np.random.default_rng(_SAMPLE_SEED + 1)
    poses = Poses.from_arrays(
        q, {"approach": rng.choice([-1.0, 1.0], q.shape), **columns}, model.nominal.slides
    )
    robot, T_sensor = model.robot, model.T_flange_sensor
    included: list[Effect] = []
    added_by: dict[str, Array] = {}
    others: list[tuple[Effect, str | None]] = []
    for effect, names in zip(model.effects, model.effect_names, strict=True):
        if isinstance(effect, PointEffect):  # acts on measured points, and moves no prediction
            continue
        try:
            bases = EffectBases.of(model.nominal, poses, (effect,))
        except InvalidInput as error:
            others.append((effect, error.faults[0].column))
            continue
        if not bases.act:  # as a tracker that was knocked, which moves no later pose of the arm
            continue
        with_effect = _with_constant_effect(robot, T_sensor, bases, effect.coefficients)
        if with_effect is None:
            others.append((effect, None))
        else:
            robot, T_sensor = with_effect
            included.append(effect)
            for name, unit in zip(names, np.eye(len(names)), strict=True):
                with_unit = _with_constant_effect(model.robot, T_sensor, bases, unit)
                if with_unit is not None:
                    added_by[name] = with_unit[0].geometry - model.robot.geometry
    rigid = robot.flange(q) @ T_sensor

    def shift(effects: Sequence[Effect]) -> tuple[float, float]:
        """Return the root mean square and the largest distance [m] by which effects move the sensor at the random poses."""
        moved = replace(model, effects=(*included, *effects))
        T = Kinematics.of(moved, poses, EffectBases.of(model.nominal, poses, moved.effects)).T_base_sensor
        distance = np.linalg.norm(T[:, :3, 3] - rigid[:, :3, 3], axis=1)
        return float(np.sqrt(np.mean(distance**2))), float(distance.max())

    left_out = tuple(
        LeftOut(effect, *((None, None) if missing else shift((effect,))), missing)
        for effect, missing in others
    )
    rms, largest = shift([effect for effect, missing in others if missing is None])
    return RigidPart(robot, T_sensor, tuple(included), added_by, left_out, rms, largest)


def _with_constant_effect(
    robot: Robot, T_sensor: Array, bases: EffectBases, c: Array
) -> tuple[Robot, Array] | None:
    """Return the robot and the sensor's pose on the flange with an effect included; None if it changes from pose to pose.

    Args:
        robot: The robot without the effect.
        T_sensor: ``(4, 4)``, the sensor on the flange without the effect.
        bases: The columns of the effect at the random poses.
        c: Its coefficients.
    """
    geometry = robot.geometry.copy()
    for basis, where in bases.joints:
        step = basis.added(np.zeros((SAMPLES, robot.n_joints)), c[where])
        if np.max(np.ptp(step, axis=0)) > _SAME:
            return None
        geometry.ravel()[robot.joint_columns] += step[0]
    for basis, where in bases.links:
        step = basis @ c[where]
        if np.max(np.ptp(step, axis=0)) > _SAME:
            return None
        geometry += step[0]
    robot = robot.with_geometry(geometry)
    for basis, where in bases.base:
        step = basis @ c[where]
        if np.max(np.ptp(step, axis=0)) > _SAME:
            return None
        robot = replace(robot, T_base_0=exp_screw(step[0]) @ robot.T_base_0)
    for basis, where in bases.sensor:
        step = basis @ c[where]
        if np.max(np.ptp(step, axis=0)) > _SAME:
            return None
        T_sensor = T_sensor @ exp_screw(step[0])
    return robot, T_sensor
