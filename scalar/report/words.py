"""What the report says of effects, in words and in units that people think in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from scalar.data.poses import is_joint
from scalar.diagnosis.profiles import Map, Profile
from scalar.effects.effect import Effect
from scalar.effects.links import AxisNonparallel, ThermalDrift
from scalar.effects.sensor import SensorSlip
from scalar.effects.unattributed import Unattributed
from scalar.units import DEG, MM, MRAD

_ORDERS_IN_TITLE, _ORDERS_IN_SENTENCE = 12, 3

_CLOCK = {"time": " s", "order": " poses"}
_NAMES = {
    "joint_compliance": "compliance",
    "joint_harmonic": "harmonic error",
    "joint_ripple": "ripple",
    "joint_scale": "scale error",
    "joint_coupling": "coupling",
    "joint_backlash": "backlash",
    "axis_nonparallel": "tilted axis",
    "base_compliance": "compliance of the base",
    "thermal_drift": "thermal drift",
    "sensor_slip": "slip of the sensor",
    "range_scale": "range scale of the laser",
    "range_offset": "range offset of the laser",
    "range_distortion": "range distortion of the laser",
    "plane_bow": "bow",
    "plane_moved": "movement",
    "pose_jitter": "jitter from pose to pose",
    "scan_bias": "bias from scan to scan",
    "unattributed": "structure without a name",
}


def title(name: str, target: Mapping[str, Any], depends_on: Sequence[str] = ()) -> str:
    """Return what an effect is called in the report: its place, then its kind."""
    kind = _NAMES.get(name, name)
    if "joints" in target:
        joints = target["joints"]
        return f"joint{'s' if len(joints) > 1 else ''} {listed([str(j) for j in joints])}: {kind}"
    if "source" in target:
        return f"joint {target['joint']}: {kind} from joint {target['source']}"
    if "orders" in target:
        return f"joint {target['joint']}: {kind}, {_orders(target['orders'], _ORDERS_IN_TITLE)}"
    if "order" in target and "joint" in target:
        return f"joint {target['joint']}: {kind}, order {target['order']}"
    if "joint" in target:
        return f"joint {target['joint']}: {kind}"
    if "plane" in target:
        return f"plate {target['plane']}: {kind}{_since(target)}"
    if depends_on:
        return f"{kind}, depending on {listed(depends_on)}"
    return f"{kind}{_since(target)}"


def _orders(orders: Sequence[int], most: int) -> str:
    if len(orders) > most:
        return f"{len(orders)} orders from {min(orders)} to {max(orders)}"
    return f"order{'s' if len(orders) > 1 else ''} {listed([str(k) for k in orders])}"


def effect_title(effect: Effect) -> str:
    """Return what an effect is called, with what drives it where its target leaves that open."""
    if isinstance(effect, ThermalDrift):
        course = f"warm-up (constant {number(effect.time_constant)}{_CLOCK.get(effect.by, '')})"
        course = course if effect.time_constant else _NAMES[effect.name]
        return f"{course} {'in the course of acquisition' if effect.by == 'order' else 'with ' + effect.by}"
    depends = effect.depends_on if isinstance(effect, Unattributed) else []
    return title(effect.name, effect.target, depends)


def column(name: str) -> str:
    """Return what a column of poses is called in a sentence."""
    if name in ("plate_u", "plate_v"):
        return "the place on the plate"
    return f"the angle of joint {name[1:]}" if is_joint(name) else f"the {name}"


def _since(target: Mapping[str, Any]) -> str:
    at = target.get("at")
    return f", from order {at['order']:.0f} on" if at and at.get("order") is not None else ""


def listed(words: Sequence[str], joint: str = "and") -> str:
    """Return words as a list in a sentence."""
    words = list(words)
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {joint} {words[-1]}"


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with a few significant digits, a true minus, and powers of ten written out."""
    if value is None or not np.isfinite(value):
        return "–"
    if value != 0 and not 1e-5 <= abs(value) < 1e5:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        raised = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        return f"{mantissa} × 10{raised}".replace("-", "−")
    decimals = 0 if value == 0 else max(digits - 1 - int(np.floor(np.log10(abs(value)))), 0)
    return f"{value:.{decimals}f}".replace("-", "−")


def length(value: float) -> str:
    """Return a length [m] in millimetres."""
    return f"{number(value / MM, 2)} mm"


def angle(value: float, digits: int = 2) -> str:
    """Return an angle [rad] in degrees."""
    return f"{number(value / DEG, digits)}°"


def chance(p: float | None) -> str:
    """Return a p-value: one number where it means something, a bound where the tail is no longer computed
    with care."""
    if p is None or not np.isfinite(p):
        return "–"
    if p < 1e-12:
        return "< 10⁻¹²"
    return number(p, 2)


def coefficient(name: str, value: float, std: float | None) -> tuple[str, str, str, str]:
    """Return a coefficient's name, value, standard error and unit for a table, in millimetres, degrees and milliradians."""
    for ending, scale, unit in (
        ("_rad_per_rad", MRAD, "mrad/rad"),
        ("_m_per_m", MM, "mm/m"),
        ("_per_m", MM, "mm/m²"),
        ("_rad", DEG, "°"),
        ("_m", MM, "mm"),
        ("_per_K", MM, "mm/m per K"),
        ("_per_pose", MM, "mm/m per pose"),
        ("_per_s", MM, "mm/m per s"),
    ):
        if name.endswith(ending):
            stem = name.removesuffix(ending).replace("_", " ")
            return stem, number(value / scale), "–" if std is None else number(std / scale, 2), unit
    return name, number(value), "–" if std is None else number(std, 2), ""


def harmonics(
    orders: Sequence[int], values: Sequence[float], stds: Sequence[float | None]
) -> list[tuple[str, ...]]:
    """Return one row an order: amplitude, its standard error, and where the wave has its top, all in
    degrees."""
    rows = []
    for i, order in enumerate(orders):
        s, c = values[2 * i], values[2 * i + 1]
        amplitude = float(np.hypot(s, c))
        errors = [e for e in stds[2 * i : 2 * i + 2] if e is not None]
        std = float(np.sqrt(np.mean(np.square(errors)))) if errors else None
        top = float(np.arctan2(s, c)) / order
        rows.append(
            (
                str(order),
                angle(amplitude, 3),
                "–" if std is None else angle(std),
                f"{top / DEG:.1f}°".replace("-", "−"),
            )
        )
    return rows


def size(effect: Effect, traces: Sequence[Profile | Map]) -> str:
    """Return how large an effect is at the poses that were measured, with its unit, or nothing."""
    if isinstance(effect, AxisNonparallel):
        return angle(abs(float(effect.coefficients[0])))
    if not traces:
        return ""
    first = traces[0]
    if isinstance(first, Map):
        largest, opening = float(np.nanquantile(np.abs(first.y), 0.98)), "about "
    else:
        largest = max(float(np.nanmax(np.abs(t.fitted))) for t in traces if isinstance(t, Profile))
        opening = "± " if first.side is not None else "" if isinstance(effect, SensorSlip) else "up to "
    if first.y_axis.unit == "rad":
        return f"{opening}{angle(largest)}"
    if first.y_axis.unit == "m":
        return f"{opening}{length(largest)}"
    return f"{opening}{number(largest / MM, 2)} mm per m" if first.y_axis.unit == "m/m" else ""


def statement(name: str, target: Mapping[str, Any], what: str) -> str:
    """Return what an effect does, as a clause of a sentence.

    Args:
        name, target: Of the effect.
        what: Its title, for what has no clause of its own.
    """
    joint, at = target.get("joint"), target.get("at") or {}
    order = at.get("order")
    since = "" if order is None else f" at order {order:.0f}"
    orders = target.get("orders") or ([target["order"]] if "order" in target else [])
    named = _orders(orders, _ORDERS_IN_SENTENCE)
    joints = [str(j) for j in target.get("joints", [])]
    many = len(joints) > 1
    give = f"joint{'s' if many else ''} {listed(joints)} give{'' if many else 's'} way"
    clauses = {
        "joint_compliance": f"{give} under the weight of the arm",
        "joint_harmonic": f"joint {joint} errs periodically, {named}",
        "joint_ripple": f"joint {joint} errs periodically and finely, {named}",
        "joint_scale": f"joint {joint} errs in proportion to its angle",
        "joint_coupling": f"joint {joint} is dragged along by joint {target.get('source')}",
        "joint_backlash": f"joint {joint} has play",
        "axis_nonparallel": f"the axis of joint {joint} is tilted against the one before",
        "base_compliance": "the base tilts under the weight of the arm",
        "sensor_slip": f"the sensor slipped on the flange{since}",
        "range_scale": "the gain of the laser is off",
        "range_offset": "the zero of the laser is off",
        "range_distortion": "the range of the laser is curved",
        "plane_bow": f"plate {target.get('plane')} is not flat",
        "plane_moved": f"plate {target.get('plane')} moved{since}",
        "pose_jitter": "each pose repeats only to a spread in the joints",
        "scan_bias": "each scan has an error of its own",
        "thermal_drift": f"the arm grows: {what}",
        "unattributed": f"there is {what}",
    }
    return clauses.get(name, what)


def capital(text: str) -> str:
    """Return a text with its first letter large."""
    return text[:1].upper() + text[1:]
