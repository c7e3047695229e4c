"""The noise for which poses are planned, where a dataset does not state one."""

from __future__ import annotations

from dataclasses import replace

from scalar.data.declared import Sensor
from scalar.estimation.result import Calibration
from scalar.sensors.rows import stated_sigma


def with_noise(sensor: Sensor, calibration: Calibration | None) -> Sensor:
    """Return a sensor with a noise: the stated one, else that which a calibration estimated, else the usual."""
    estimated = None if calibration is None else calibration.summary.get("sigma_m")
    return replace(sensor, noise=stated_sigma(estimated if sensor.noise is None else sensor.noise))
