"""Calibrations for tests, made without a fit: an arm of a description or a file, every parameter off, with effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
from scalar.effects.effect import Effect
from scalar.estimation.result import Calibration
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import transform_from_rotation_vector

T_SENSOR = transform_from_rotation_vector([0.05, -0.02, 0.11], [0.3, -0.2, 2.0])


def calibrated(
    robot: Robot, rng: np.random.Generator, effects: tuple[Effect, ...] = (), size: float = 1.0
) -> Calibration:
    """Return a calibration of a nominal robot: a and d off by a millimetre, angles by two milliradians (times ``size``), the sensor known."""
    points = rng.normal(size=(robot.n_joints + 4, 3))
    q = rng.uniform(-1, 1, (len(points), robot.n_joints))
    dataset = Dataset.from_arrays(robot=robot, sensor=Sensor("tracker", T_SENSOR), q=q, points=points)
    calibration = Calibration.nominal(dataset)
    error = size * rng.normal(size=robot.geometry.shape) * np.array([1e-3, 2e-3, 1e-3, 2e-3, 2e-3])[:, None]
    model = replace(calibration.model, robot=robot.with_geometry(robot.geometry + error), effects=effects)
    return replace(calibration, model=model)


def rigid(calibration: Calibration) -> Calibration:
    """Return a calibration without its effects."""
    return replace(calibration, model=replace(calibration.model, effects=()))
