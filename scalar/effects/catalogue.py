"""The list of effects by name: what ``--effects`` frees, what the diagnosis tries, what a calibration file holds."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.effects.base import BaseCompliance
from scalar.effects.effect import Effect
from scalar.effects.joints import (
    JointBacklash,
    JointCompliance,
    JointCoupling,
    JointHarmonic,
    JointRipple,
    JointScale,
)
from scalar.effects.links import AxisNonparallel, ThermalDrift
from scalar.effects.sensor import RangeDistortion, RangeOffset, RangeScale, SensorSlip
from scalar.effects.surface import PlaneBow, PlaneMoved
from scalar.effects.unattributed import Unattributed
from scalar.errors import Fault, InvalidInput
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

CATALOGUE: dict[str, type[Effect]] = {
    effect.name: effect
    for effect in (
        JointCompliance,
        JointHarmonic,
        JointRipple,
        JointScale,
        JointCoupling,
        JointBacklash,
        AxisNonparallel,
        BaseCompliance,
        ThermalDrift,
        SensorSlip,
        RangeScale,
        RangeOffset,
        RangeDistortion,
        PlaneBow,
        PlaneMoved,
        Unattributed,
    )
}

MAX_ORDER = 32  # of a joint's harmonics
MAX_RIPPLE_ORDER = 64
DRIFT_DRIVERS = ("temperature", "time", "order")


def effect_to_mapping(effect: Effect, std: Mapping[str, float]) -> dict[str, Any]:
    """Return an effect as calibrations and diagnoses write it.

    Args:
        effect: With its coefficients.
        std: Standard errors by parameter name, for those that were estimated.
    """
    return {
        "name": effect.name,
        "target": effect.target,
        "coefficients": {
            name: {"value": float(value), "std": float(std[key]) if key in std else None}
            for name, key, value in zip(
                effect.coefficient_names, effect.parameter_names, effect.coefficients, strict=True
            )
        },
        "settings": effect.to_mapping(),
    }


def effect_from_mapping(mapping: Mapping[str, Any]) -> Effect:
    """Return the effect that ``effect_to_mapping`` wrote."""
    effect = CATALOGUE[mapping["name"]].from_mapping(mapping["settings"])
    values = [mapping["coefficients"][name]["value"] for name in effect.coefficient_names]
    return effect.with_coefficients(values)


def drift_driver(dataset: Dataset) -> str:
    """Return what may drive a thermal drift: the temperature where it is recorded and varies, else the time, else the order."""
    for name in ("temperature", "time"):
        if name in dataset.poses and float(np.ptp(dataset.poses[name].to_numpy(dtype=float))) > 0:
            return name
    return "order"


def backlash_driver(dataset: Dataset, joint: int) -> str:
    """Return what tells a joint's side of its play: the recorded approach where it varies, else the torque's sign."""
    name = f"approach{joint}"
    return (
        "approach"
        if name in dataset.poses and len(np.unique(dataset.poses[name].to_numpy())) > 1
        else "torque"
    )


def plane_centre(dataset: Dataset, plane: str) -> tuple[float, float, float]:
    """Return a point in the middle of where the nominal sensor stood over a plane, dropped on its rough guess [m]."""
    k = next(i for i, guess in enumerate(dataset.planes) if guess.name == plane)
    T_sensor = np.eye(4) if dataset.sensor.T_flange_sensor is None else dataset.sensor.T_flange_sensor
    origins = (dataset.robot.flange(dataset.q[dataset.plane_index == k]) @ T_sensor)[:, :3, 3]
    middle = origins.mean(axis=0)
    guess = dataset.planes[k]
    x, y, z = middle - guess.normal * (guess.normal @ middle - guess.distance)
    return float(x), float(y), float(z)


def range_middle(dataset: Dataset) -> float:
    """Return the mean of the measured ranges [m], along the axis in which the scanner errs."""
    points = dataset.points
    return float(
        np.mean(points[:, 1] if dataset.sensor.error_axis == "z" else np.linalg.norm(points, axis=1))
    )


def _joints(dataset: Dataset, words: Sequence[str]) -> list[int]:
    n = dataset.robot.n_joints
    if not words:
        return list(range(1, n + 1))
    if not words[0].isdecimal() or not 1 <= int(words[0]) <= n:
        raise ValueError(f"'{words[0]}' is no joint; this robot has joints 1 to {n}")
    return [int(words[0])]


def _order(word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise ValueError(f"'{word}' is no order of acquisition; say from which pose on, as a number")
    return value


def _planes(dataset: Dataset, words: Sequence[str]) -> list[str]:
    names = [plane.name for plane in dataset.planes]
    if not words:
        return names
    if words[0] not in names:
        raise ValueError(f"no plane '{words[0]}'; there are {', '.join(names)}")
    return [words[0]]


def _compliance(dataset: Dataset, words: Sequence[str]) -> list[Effect]:
    n = dataset.robot.n_joints
    return [JointCompliance(tuple((j, f) for j in _joints(dataset, words) for f in range(j, n + 1)))]


def _harmonic(dataset: Dataset, words: Sequence[str]) -> list[Effect]:
    orders = _orders(words[1:], 1, MAX_ORDER) or (1,)
    return [JointHarmonic(j, orders) for j in _joints(dataset, words)]


def _ripple(dataset: Dataset, words: Sequence[str]) -> list[Effect]:
    orders = _orders(words[1:], MAX_ORDER + 1, MAX_RIPPLE_ORDER)
    if not orders:
        raise ValueError("name the joint and its orders, as in joint_ripple:3:40:48")
    return [JointRipple(j, orders) for j in _joints(dataset, words)]


def _orders(words: Sequence[str], first: int, last: int) -> tuple[int, ...]:
    wrong = [word for word in words if not word.isdecimal() or not first <= int(word) <= last]
    if wrong:
        raise ValueError(f"'{wrong[0]}' is no order; there are orders {first} to {last}")
    return tuple(sorted({int(word) for word in words}))


def _coupling(dataset: Dataset, words: Sequence[str]) -> list[Effect]:
    if len(words) < 2:
        raise ValueError("name the joint and its source, as in joint_coupling:6:5")
    joint, source = _joints(dataset, words[:1])[0], _joints(dataset, words[1:])[0]
    if joint == source:
        raise ValueError(f"a joint that errs with its own angle is joint_scale:{joint}")
    return [JointCoupling(joint, source)]


def _nonparallel(dataset: Dataset, words: Sequence[str]) -> list[Effect]:
    from scalar.geometry.parallel_axes import near_parallel_joints

    return [
        AxisNonparallel(j)
        for j in (_joints(dataset, words) if words else near_parallel_joints(dataset.robot))
    ]


def _drift(dataset: Dataset, words: Sequence[str]) -> list[Effect]:
    by = words[0] if words else drift_driver(dataset)
    if by not in DRIFT_DRIVERS:
        raise ValueError(f"'{by}' drives no drift; there are {', '.join(DRIFT_DRIVERS)}")
    if by == "order":
        order = (
            dataset.poses["order"].to_numpy(dtype=float)
            if "order" in dataset.poses
            else np.arange(dataset.n_poses)
        )
        return [ThermalDrift("order", float(order.min()), last=float(order.max()))]
    if by not in dataset.poses:
        raise ValueError(f"poses.csv has no column '{by}'")
    return [ThermalDrift(by, float(np.min(dataset.poses[by].to_numpy(dtype=float))))]


def _slip(dataset: Dataset, words: Sequence[str]) -> list[Effect]:
    if not words:
        raise ValueError("say from which order on, as in sensor_slip:120")
    return [SensorSlip(_order(words[0]), turns=kind_of(dataset).observes_orientation)]


def _moved(dataset: Dataset, words: Sequence[str]) -> list[Effect]:
    if len(words) < 2:
        raise ValueError("name the plane and from which order on, as in plane_moved:floor:120")
    plane = _planes(dataset, words)[0]
    return [PlaneMoved(plane, _order(words[1]), None, plane_centre(dataset, plane))]


_MAKERS: dict[str, Callable[[Any, Sequence[str]], list[Effect]]] = {
    "joint_compliance": _compliance,
    "joint_harmonic": _harmonic,
    "joint_ripple": _ripple,
    "joint_scale": lambda dataset, words: [JointScale(j) for j in _joints(dataset, words)],
    "joint_coupling": _coupling,
    "joint_backlash": lambda dataset, words: [
        JointBacklash(j, backlash_driver(dataset, j)) for j in _joints(dataset, words)
    ],
    "axis_nonparallel": _nonparallel,
    "base_compliance": lambda dataset, words: [BaseCompliance(tuple(range(1, dataset.robot.n_joints + 1)))],
    "thermal_drift": _drift,
    "sensor_slip": _slip,
    "range_scale": lambda dataset, words: [RangeScale()],
    "range_offset": lambda dataset, words: [RangeOffset()],
    "range_distortion": lambda dataset, words: [RangeDistortion(range_middle(dataset))],
    "plane_bow": lambda dataset, words: [
        PlaneBow(p, plane_centre(dataset, p)) for p in _planes(dataset, words)
    ],
    "plane_moved": _moved,
}
_MOST_WORDS = {
    "joint_harmonic": 1 + MAX_ORDER,
    "joint_ripple": 1 + MAX_RIPPLE_ORDER - MAX_ORDER,
    "joint_coupling": 2,
    "plane_moved": 2,
}


def parse_effects(text: str, dataset: Dataset) -> tuple[Effect, ...]:
    """Return the effects that a command line names: ``NAME[:TARGET[:...]]``, separated by commas.

    Joints, orders, planes and moments follow the name: ``joint_harmonic:4:2``, ``joint_coupling:6:5``, ``plane_bow:floor``,
    ``sensor_slip:120``. Without a target an effect is freed wherever it can act.

    Raises:
        InvalidInput: An unknown name, or a target that this dataset lacks.
    """
    effects: list[Effect] = []
    faults = []
    for word in (part.strip() for part in text.split(",")):
        if not word:
            continue
        name, *target = word.split(":")
        if name not in _MAKERS:
            close = difflib.get_close_matches(name, _MAKERS, n=1)
            hint = f"; did you mean {close[0]}?" if close else f"; there are {', '.join(_MAKERS)}"
            faults.append(Fault("--effects", f"no effect '{name}' that can be freed{hint}"))
            continue
        try:
            if len(target) > _MOST_WORDS.get(name, 1):
                raise ValueError(f"too many words after '{name}'")
            effects += _MAKERS[name](dataset, target)
        except ValueError as error:
            faults.append(Fault("--effects", f"{word}: {error}"))
    keys = [effect.key for effect in effects]
    faults += [
        Fault("--effects", f"'{key}' is named twice")
        for key in sorted({k for k in keys if keys.count(k) > 1})
    ]
    if faults:
        raise InvalidInput(faults)
    return tuple(effects)
