"""The fields of a calibration from the content of its file, and the part of the file that restores a standard-DH table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from scalar.effects.saving import effect_from_mapping
from scalar.estimation.model import Model, ParameterPrior
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import log_so3, transform_from_rotation_vector
from scalar.sensors import kind_named


def standard_dh_mapping(nominal: Robot) -> dict[str, Any]:
    """Return a and alpha of the last link of a standard-DH table, which the modified-DH parameters in the file lack; else nothing."""
    if nominal.standard_end is None:
        return {}
    a, alpha = nominal.standard_end
    return {"standard_dh": {"a": a, "alpha": alpha}}


def saved_fields(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a ``Calibration``, by name, from the content of its file.

    Args:
        mapping: The content of ``calibration.json``, checked.
    """
    parameters = mapping["parameters"]
    stated = mapping["robot"].get("standard_dh")
    end = None if stated is None else (float(stated["a"]), float(stated["alpha"]))
    nominal, calibrated = (
        replace(Robot.from_mapping(mapping["robot"][state]), standard_end=end)
        for state in ("nominal", "calibrated")
    )
    sensor = {key: mapping["sensor"][key] for key in ("kind", "noise", "error_axis")}
    pose = mapping["sensor"]["pose"]
    T = transform_from_rotation_vector(pose["translation"], pose["rotation_vector"])
    target = kind_named(sensor["kind"]).target_from_mapping(mapping)
    effects = tuple(effect_from_mapping(effect) for effect in mapping["effects"])
    priors = tuple(
        ParameterPrior(name, float(entry["prior"]["value"]), float(entry["prior"]["std"]), "")
        for name, entry in parameters.items()
        if entry.get("prior") is not None
    )
    model = Model(
        calibrated, nominal, np.eye(3), np.r_[T[:3, 3], log_so3(T[:3, :3])], target, effects, priors
    )
    model = model.with_vector(np.array([float(parameters[name]["value"]) for name in model.names]))
    return dict(
        model=model,
        sensor=sensor,
        free=tuple(mapping["names"]),
        covariance=np.array(mapping["covariance"], dtype=float).reshape(2 * (len(mapping["names"]),)),
        fixed={name: p["reason"] for name, p in parameters.items() if p["held"]},
        gauge=tuple(mapping["gauge"]),
        residual_rms=float(mapping["residual_rms_m"]),
        summary=mapping["summary"],
        noise=tuple(mapping.get("noise", ())),
    )
