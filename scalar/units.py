"""The units that people write, as multiples of the SI units that the code computes in.

Inside, everything is in metres, radians, seconds and float64. Multiply by a constant of this module to enter
SI, divide by it to leave: ``0.1 * MM`` is a tenth of a millimetre in metres, ``angle / DEG`` an angle
in degrees. These numbers stand in this file only; a test looks for them elsewhere.
"""

import math

MM = 1e-3
"""One millimetre [m]."""

UM = 1e-6
"""One micrometre [m]."""

MS = 1e-3
"""One millisecond [s]."""

DEG = math.pi / 180.0
"""One degree [rad]."""

MRAD = 1e-3
"""One milliradian [rad]. The same number as a millimetre, but another unit."""


def unit_of_joint(slides: bool) -> tuple[str, float]:
    """Return the unit in which people write a joint's position, ``mm`` or ``deg``, and its size [m or rad]."""
    return ("mm", MM) if slides else ("deg", DEG)
