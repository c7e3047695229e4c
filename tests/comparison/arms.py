"""Calibrations for the tests of comparisons, with independent standard errors of all that the choice of frames leaves free."""

from dataclasses import replace

import numpy as np

from scalar.data.io.plain_yaml import load_yaml
from scalar.estimation.result import Calibration
from scalar.geometry.robot import Robot
from tests.calibrated_arms import calibrated
from tests.robot_configs import ROBOT_CONFIGS

ANGLE, LENGTH = 2e-5, 2e-5  # standard errors [rad, m]
FRAMES = ("a_1", "alpha_1", "d_1", "theta_1", "d_6", "theta_6", "d_2")  # fixed by the choice of frames


def ur10e() -> Robot:
    """Return an arm with three parallel axes."""
    return Robot.from_mapping(load_yaml(ROBOT_CONFIGS / "ur10e.yaml"))


def with_errors(calibration, fixed=FRAMES, cause="structural"):
    """Return a calibration with independent standard errors of all that is neither beta nor fixed."""
    geometry = [name for name in calibration.model.robot.parameter_names if not name.startswith("beta")]
    effects = [name for names in calibration.model.effect_names for name in names]
    free = tuple(name for name in (*geometry, "sensor_x", *effects) if name not in fixed)
    sizes = [LENGTH if name[0] in "ads" and not name.startswith("alpha") else ANGLE for name in free]
    gauge = tuple({"held": name, "reason": "", "moves_with": [], "cause": cause} for name in fixed)
    return replace(calibration, free=free, covariance=np.diag(sizes) ** 2, gauge=gauge)


def arm_before() -> Calibration:
    """Return a calibration of an arm whose axes are off by little, so that parallel ones stay as good as parallel."""
    return with_errors(calibrated(ur10e(), np.random.default_rng(3), size=1e-3))


def changed(calibration, **by):
    """Return a calibration with some parameters larger."""
    model = calibration.model
    vector = model.vector.copy()
    for name, step in by.items():
        vector[model.names.index(name)] += step
    return replace(calibration, model=model.with_vector(vector))


def by_chance(calibration, rng):
    """Return a calibration whose estimates differ as its covariance says."""
    steps = np.sqrt(np.diag(calibration.covariance)) * rng.standard_normal(len(calibration.free))
    return changed(calibration, **dict(zip(calibration.free, steps, strict=True)))
