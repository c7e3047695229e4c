"""Numbers with units as people read them: what effects, the report and the terminal write."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from scalar.data.poses import is_joint
from scalar.units import DEG, MM, MRAD

UNKNOWN = "–"

OWN_SESSION = "a session of their own (column session in poses.csv; order is a column there, too, and without it the rows count from 0)"
"""What poses after a sudden change are to get."""


def listed(words: Sequence[str], conjunction: str = "and") -> str:
    """Return words as a list in a sentence, with ``conjunction`` before the last."""
    words = list(words)
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {conjunction} {words[-1]}"


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with a few significant digits, a minus sign instead of a hyphen, and powers of ten as in ``1.2 × 10⁻⁷``."""
    if value is None or not np.isfinite(value):
        return UNKNOWN
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


_OF_BASE = re.compile(r"frame(\d+)_([xyz])")
_TILTS_OF_PLANE = {
    "tilt_u": "tilt along one direction u in the plane",
    "tilt_v": "tilt along v, square to u",
}
_OF_WEIGHT = re.compile(r"joint(\d+)_frame(\d+)_([xyz])")


def coefficient(name: str, value: float, std: float | None) -> tuple[str, str, str, str]:
    """Return a coefficient's name, value, standard error and unit for a table, in millimetres, degrees and milliradians.

    The end of the name states the unit in the files; ``per_m`` without a unit before it is one over metres.
    """
    for ending, scale, unit in (
        ("_rad_per_rad", MRAD, "mrad/rad"),
        ("_rad_per_Nm", MRAD, "mrad per N m"),
        ("_m_per_m", MM, "mm/m"),
        ("_per_m", MM, "mm/m²"),
        ("_rad", DEG, "°"),
        ("_m", MM, "mm"),
        ("_per_K", MM, "mm/m per K"),
        ("_per_pose", MM, "mm/m per pose"),
        ("_per_s", MM, "mm/m per s"),
        ("_poses", 1.0, "poses"),
        ("_s", 1.0, "s"),
    ):
        if name.endswith(ending):
            stem = _OF_WEIGHT.sub(
                r"joint \1 by the weight of link \2 along \3, at its longest lever", name.removesuffix(ending)
            )
            if (of_base := _OF_BASE.fullmatch(stem)) is not None:
                stem = of_base.expand(r"tilt by the masses along \2 of frame \1")
            stem = _TILTS_OF_PLANE.get(stem, stem.replace("_", " "))
            return stem, *with_error(value / scale, None if std is None else std / scale), unit
    return name, *with_error(value, std), ""


def with_error(value: float, std: float | None) -> tuple[str, str]:
    """Return a number and its standard error, the latter with about two significant digits and the number with as many decimals as it.

    Without an error, or where one of the two is zero, very small or very large, the number has three significant digits.
    """
    if std is None:
        return number(value), UNKNOWN
    error = number(std, 2)
    if std == 0 or "×" in error or not np.isfinite(value) or not np.isfinite(std) or abs(value) >= 1e5:
        return number(value), error
    decimals = len(error.partition(".")[2])
    shown = f"{value:.{decimals}f}".replace("-", "−")
    return shown.removeprefix("−") if not float(f"{value:.{decimals}f}") else shown, error


def stiffness_row(joint: int, value: float, std: float | None) -> tuple[str, str, str, str]:
    """Return the stiffness of a joint for a table; one that is not known (NaN) is more than ``std``.

    Args:
        joint: From 1.
        value, std: Stiffness and standard error [N m/rad].
    """
    name, unit = f"joint {joint} stiffness", "N m/rad"
    if np.isnan(value):
        return name, f"more than {number(std, 2)}", UNKNOWN, unit
    return name, number(value), number(std, 2), unit


_RATIOS = {
    "rad/rad": (MRAD, "mrad per rad"),
    "rad/(N m)": (MRAD, "mrad per N m"),
    "m/m": (MM, "mm per m"),
    "1/m": (MM, "mm/m²"),
    "1/K": (MM, "mm per m and kelvin"),
    "1/s": (MM, "mm per m and second"),
    "1/pose": (MM, "mm per m and pose"),
}
"""Units of coefficients that are ratios: the size of the unit in which they are shown, and its name."""


def sized(value: float, unit: str) -> str:
    """Return in words the value of a coefficient whose unit is one of those that effects use (rad, m, rad/rad ...)."""
    if unit == "rad":
        return angle(value)
    if unit in _RATIOS:
        size, shown = _RATIOS[unit]
        return f"{number(value / size, 2)} {shown}"
    return length(value) if unit == "m" else f"{number(value, 2)} {unit}"


def orders(numbers: Sequence[int], most: int) -> str:
    """Return orders of a series in words: each of them, or from where to where if there are more than ``most``."""
    if len(numbers) > most:
        return f"{len(numbers)} orders from {min(numbers)} to {max(numbers)}"
    return f"order{'s' if len(numbers) > 1 else ''} {listed([str(k) for k in numbers])}"


def side_of_travel(coefficients: Sequence[float]) -> str:
    """Return what the sign of half widths means for a joint that errs by them in the direction from which it came; empty if they differ in sign."""
    if all(value < 0 for value in coefficients):
        return "the joint stays behind its reading, on the side from which it came"
    if all(value > 0 for value in coefficients):
        return "the joint stands beyond its reading, away from the side from which it came"
    return ""


def periods(numbers: Sequence[int], most: int) -> str:
    """Return orders of a series as periods a turn: each of them, or from where to where if there are more than ``most``."""
    if len(numbers) > most:
        return f"between {min(numbers)} and {max(numbers)} periods a turn"
    return f"{listed([str(k) for k in numbers])} period{'' if list(numbers) == [1] else 's'} a turn"


def columns_in_words(names: Sequence[str]) -> str:
    """Return what columns of poses.csv, and other quantities on which structure may depend, are called in a sentence.

    A joint has a position, which is an angle or a travel.
    """
    joints = [str(j) for j in sorted({int(name[1:]) for name in names if is_joint(name)})]
    found = (
        [
            f"the position{'s' if len(joints) > 1 else ''} of joint{'s' if len(joints) > 1 else ''} {listed(joints)}"
        ]
        if joints
        else []
    )
    found += [_called(name) for name in names if not is_joint(name)]
    return listed(list(dict.fromkeys(found)))


def _called(name: str) -> str:
    """Return what a column that is no joint's position is called in a sentence."""
    joint = name.removeprefix("approach")
    if joint != name and joint.isdecimal():
        return f"the direction of approach of joint {joint}"
    return _CALLED.get(name, f"the recorded {name}")


_CALLED = {
    "gravity": "the direction of gravity",
    "order": "the order of acquisition",
    "time": "the time",
    "temperature": "the temperature",
    "session": "the session",
    "measured_position": "the measured position",
    "profile_x": "the place in the scanner's profile",
    "incidence": "the angle at which the scanner looks at the plane",
    "plane_u": "the place on the target plane",
    "plane_v": "the place on the target plane",
}

KNOWN_LENGTH = "a reference of known length would show it"
KNOWN_LENGTH_ADVICE = (
    "Add lengths that are known: measure where three target planes that are not parallel stand in the base frame, and state it in dataset.yaml "
    "(known: {distance_std: ..., normal_std: ...} of each plane). They fix the scale, which these data do not determine. One or two of them may "
    "leave it open, and 'scalar calibrate' says if they do."
)
"""What would show an error that scales the whole workcell: a clause, and whole sentences of advice."""
