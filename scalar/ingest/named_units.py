"""Convert the units of foreign files to SI, for columns and for the numbers of a dataset's description.

Lengths in other units are rounded to the 15 digits that every float64 holds, so that 383.97123 mm become
0.38397123 m and not a neighbouring float.
"""

import copy
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from scalar.ingest.orientation import wrong_axes
from scalar.units import DEG, MM


def _to_m(size: float) -> Callable[[Any], Any]:
    """Return the function that converts lengths in a unit of this size [m], a number or an array of them, to metres."""

    def converted(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return np.array([converted(x) for x in value.tolist()], dtype=float)
        return float(f"{value * size:.15g}")

    return converted


UNITS: dict[str, dict[str, Callable[[Any], Any]]] = {
    "length": {"m": lambda value: value, "mm": _to_m(MM), "cm": _to_m(10 * MM), "in": _to_m(25.4 * MM)},
    "angle": {"rad": lambda value: value, "deg": lambda value: value * DEG},
    "torque": {"Nm": lambda value: value},
    "force": {"N": lambda value: value},
    "mass": {"kg": lambda value: value},
    "time": {"s": lambda value: value},
    "temperature": {"degC": lambda value: value},
}
"""``{quantity: {unit: conversion to SI}}``; temperatures stay in degrees Celsius, as in poses.csv."""

_FOREIGN = {"m": ("length", "mm", "millimetres"), "rad": ("angle", "deg", "degrees")}
"""``{unit in the dataset: (quantity, the unit in which files have it instead, that unit in words)}``."""
_EULER = "rotation_euler"


def unit_of_column(stated: str, key: str, file: str, si: str) -> str:
    """Return the end of a message about a column whose numbers look like millimetres or degrees: what the user should do.

    Args:
        stated: The unit that the mapping states for the column; empty if none.
        key: Where the column stands in the mapping, such as ``points.columns.x``.
        file: Name of the mapping file.
        si: The unit of the column in the dataset, ``m`` or ``rad``.
    """
    _, foreign, words = _FOREIGN[si]
    if stated == foreign:
        return f"{key} in {file} states unit: {foreign} already; correct the column in the mapping, or the numbers in the file"
    return f"are these {words}? write unit: {foreign} for {key} in {file}"


def units_of_dataset(stated: Mapping[str, str], si: str) -> str:
    """Return the end of a message about a number under the key ``dataset`` of a mapping that looks like millimetres or degrees: what to do.

    Args:
        stated: ``{quantity: unit}``, as the mapping states under ``dataset_units``.
        si: The unit of the number in the dataset, ``m`` or ``rad``.
    """
    quantity, foreign, words = _FOREIGN[si]
    if stated.get(quantity) == foreign:
        return f"dataset_units states {quantity}: {foreign} already; correct the number"
    return f"are these {words}? if every {quantity} under dataset is, write dataset_units: {{{quantity}: {foreign}}}, else write {si}"


def description_to_si(
    mapping: Any, length: str, angle: str
) -> tuple[Any, list[tuple[tuple[str | int, ...], str]]]:
    """Return a copy of a description in metres, radians and rotation vectors, and the faults of its Euler angles, each as place and message.

    ``rotation_euler: {axes: XYZ, angles: [a, b, c]}`` may stand in place of ``rotation_vector``: capitals
    turn about the moving axes (intrinsic), small letters about the fixed axes (extrinsic), in that order.

    Args:
        mapping: the content of dataset.yaml, not yet checked; whatever is not a number is kept.
        length: the unit of its lengths, such as ``mm``.
        angle: the unit of its angles, ``rad`` or ``deg``.
    """
    mapping = copy.deepcopy(mapping)
    to_m, to_rad = UNITS["length"][length], UNITS["angle"][angle]
    faults: list[tuple[tuple[str | int, ...], str]] = []
    for joint in _items(mapping, "robot", "joints"):
        _convert(joint, ("a", "d"), to_m)
        _convert(joint, ("alpha", "theta", "beta"), to_rad)
        slides = isinstance(joint, dict) and joint.get("type") == "prismatic"
        _convert(joint, ("limits",), to_m if slides else to_rad)
    for path in (("robot", "base"), ("robot", "flange"), ("sensor", "nominal_pose")):
        transform = _get(mapping, *path)
        _convert(transform, ("translation",), to_m)
        _convert(transform, ("rotation_vector",), to_rad)
        if isinstance(transform, dict) and _EULER in transform:
            message = _euler_to_vector(transform, to_rad)
            if message:
                faults.append(((*path, _EULER), message))
    _convert(_get(mapping, "robot", "tolerance"), ("length",), to_m)
    _convert(_get(mapping, "robot", "tolerance"), ("angle",), to_rad)
    _convert(_get(mapping, "sensor"), ("noise",), to_m)
    _convert(_get(mapping, "sensor"), ("rotation_noise",), to_rad)
    for plane in _items(mapping, "planes"):
        _convert(plane, ("distance",), to_m)
        _convert(_get(plane, "known"), ("distance_std",), to_m)
        _convert(_get(plane, "known"), ("normal_std",), to_rad)
        _convert(_get(plane, "extent"), ("centre", "radius"), to_m)
    return mapping, faults


def _euler_to_vector(transform: dict[str, Any], to_rad: Callable[[Any], Any]) -> str | None:
    """Replace Euler angles by the rotation vector; return the message about a fault, or None."""
    given = transform.pop(_EULER)
    if "rotation_vector" in transform:
        return "rotation_vector is there too, and only one can be meant; remove one"
    transform["rotation_vector"] = [0.0, 0.0, 0.0]
    if not isinstance(given, dict) or set(given) != {"axes", "angles"}:
        return "write {axes: XYZ, angles: [0, 0, 0]}"
    axes, angles = given["axes"], given["angles"]
    wrong = wrong_axes(axes)
    if wrong:
        return wrong
    if not isinstance(angles, list) or len(angles) != 3 or not all(map(_is_number, angles)):
        return "angles are not three numbers; write them as [0, 0, 0]"
    vector = Rotation.from_euler(axes, [to_rad(float(x)) for x in angles]).as_rotvec()
    transform["rotation_vector"] = vector.tolist()
    return None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300


def _convert(mapping: Any, keys: tuple[str, ...], to_si: Callable[[Any], Any]) -> None:
    """Convert the numbers under these keys, those in lists included; anything else is kept, and checked later."""
    for key in keys if isinstance(mapping, dict) else ():
        value = mapping.get(key)
        if isinstance(value, list):
            mapping[key] = [to_si(x) if _is_number(x) else x for x in value]
        elif _is_number(value):
            mapping[key] = to_si(value)


def _get(mapping: Any, *path: str) -> Any:
    for key in path:
        mapping = mapping.get(key) if isinstance(mapping, dict) else None
    return mapping


def _items(mapping: Any, *path: str) -> list[Any]:
    value = _get(mapping, *path)
    return value if isinstance(value, list) else []
