"""Check the content of a calibration file: against its schema, and each part against the others.

A file that was damaged or edited could predict poses that are slightly wrong, without any sign of it. Parts that contradict each other are
therefore refused, and the message names their key.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from jsonschema import Draft202012Validator

from scalar.data.description import Description, KeyPath, check_schema
from scalar.data.io.atomic import plain
from scalar.data.strict_schema import strict_validator
from scalar.effects.effect import Effect
from scalar.errors import InvalidInput
from scalar.estimation.measured_ranges import MEASURED_RANGES
from scalar.geometry.se3 import Array

_ROUNDING = 1e-6  # relative: what a covariance may be off by rounding
_JOINTS = ("joint", "source", "joints")


@cache
def _validator() -> Draft202012Validator:
    """Return the validator of calibration files."""
    schemas = resources.files("scalar.estimation").joinpath("schemas")
    return strict_validator(
        json.loads(schemas.joinpath("calibration.schema.json").read_text(encoding="utf-8"))
    )


def check_calibration(mapping: Any, file: str) -> None:
    """Refuse the content of a calibration of version 2 that is not what it should be.

    Args:
        mapping: The plain data of the file.
        file: Its name, in messages.

    Raises:
        InvalidInput: With every fault found, each with its key.
    """
    content = Description(mapping, {}, file)
    check_schema(content, _validator())
    if not content.faults:
        _check_sizes(content)
        _check_joints(content)
    if content.faults:
        raise InvalidInput(content.faults)


def check_effects_made(effects: Sequence[Effect], mapping: Any, file: str) -> None:
    """Refuse effects whose target or coefficients contradict their settings in the file.

    Args:
        effects: Built from the effects' settings in the file.
        mapping: The plain data of the file.
        file: Its name, in messages.

    Raises:
        InvalidInput: With the key of each contradiction.
    """
    content = Description(mapping, {}, file)
    for i, (effect, entry) in enumerate(zip(effects, mapping["effects"], strict=True)):
        if plain(effect.target) != entry["target"]:
            message = f"contradicts the effect's settings, which say {json.dumps(plain(effect.target))}"
            content.fault(("effects", i, "target"), f"{message}; calibrate again")
        for name in sorted(entry["coefficients"].keys() - set(effect.coefficient_names)):
            content.fault(
                ("effects", i, "coefficients", name), f"no coefficient of {effect.name}; calibrate again"
            )
    if content.faults:
        raise InvalidInput(content.faults)


def _check_sizes(content: Description) -> None:
    """Add a fault for every list whose length contradicts that of another."""
    n = len(content.items("robot", "nominal", "joints"))
    calibrated = len(content.items("robot", "calibrated", "joints"))
    if calibrated != n:
        content.fault(
            ("robot", "calibrated", "joints"),
            f"{calibrated} joints where the nominal arm has {n}; calibrate again",
        )
    ranges = content.items("summary", MEASURED_RANGES)
    if ranges and len(ranges) != n:
        message = f"{len(ranges)} ranges where the arm has {n} joints; calibrate again"
        content.fault(("summary", MEASURED_RANGES), message)
    names = content.items("names")
    for i, name in enumerate(names):
        if name not in content.mapping["parameters"]:
            content.fault(("names", i), f"no parameter is called {name!r}; calibrate again")
    if len(set(names)) < len(names):
        content.fault(("names",), "a name stands here twice; calibrate again")
    rows = content.items("covariance")
    if len(rows) != len(names) or any(len(row) != len(names) for row in rows):
        content.fault(
            ("covariance",),
            f"not a matrix of {len(names)} rows and columns, as names has it; calibrate again",
        )
    elif names and not content.faults:
        _check_covariance(content, names, np.array(rows, dtype=float))


def _check_covariance(content: Description, names: Sequence[str], covariance: Array) -> None:
    """Add a fault where the matrix is no covariance, or contradicts the standard errors of the parameters; null: the fit gave none."""
    if not np.isfinite(covariance).all():
        return
    variances = np.diag(covariance)
    if np.any(variances < 0.0):
        content.fault(
            ("covariance",),
            f"the variance of {names[int(np.argmin(variances))]} is negative; calibrate again",
        )
        return
    for name, variance in zip(names, variances.tolist(), strict=True):
        std = content.get("parameters", name, "std")
        if std is not None and abs(std - variance**0.5) > _ROUNDING * max(std, variance**0.5):
            message = f"contradicts the covariance, by which it is {variance**0.5:g}; calibrate again"
            content.fault(("parameters", name, "std"), message)
    std = np.sqrt(variances)
    correlation = covariance / np.maximum(np.outer(std, std), np.finfo(float).tiny)
    i, j = divmod(int(np.argmax(np.abs(correlation - correlation.T))), len(names))
    if abs(correlation[i, j] - correlation[j, i]) > _ROUNDING:
        content.fault(("covariance",), f"not symmetric for {names[i]} and {names[j]}; calibrate again")
    elif np.abs(correlation).max() > 1.0 + _ROUNDING or np.linalg.eigvalsh(correlation)[0] < -_ROUNDING:
        content.fault(("covariance",), "no parameters vary together as it says; calibrate again")


def _check_joints(content: Description) -> None:
    """Add a fault for every joint of an effect that the robot does not have."""
    n = len(content.items("robot", "nominal", "joints"))
    for i in range(len(content.items("effects"))):
        for part in ("target", "settings"):
            for path, joint in _joints(content.get("effects", i, part), ("effects", i, part)):
                if isinstance(joint, bool) or not isinstance(joint, int) or not 1 <= joint <= n:
                    content.fault(path, f"{joint!r} is no joint; this robot has joints 1 to {n}")


def _joints(mapping: dict[str, Any], path: KeyPath) -> Iterator[tuple[KeyPath, Any]]:
    """Yield each joint that a target or settings name, with its path."""
    for key in _JOINTS:
        value = mapping.get(key, [])
        if isinstance(value, list):
            yield from (((*path, key, i), joint) for i, joint in enumerate(value))
        else:
            yield (*path, key), value
