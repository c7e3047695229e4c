"""The noise within scans as components with a name, a size and a sentence: level, correlation along the rays, waviness of the surface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from scalar.sensors.pose_noise import NoiseComponent
from scalar.sensors.within_scan_noise.correlation_shapes import Part
from scalar.sensors.within_scan_noise.level import Level
from scalar.units import MM

_LISTED = 4.0  # standard errors: only exponents that differ from zero by more are listed


def components(
    parts: Sequence[Part], level: Level, stated: float, found: float, varies: bool, off: bool
) -> tuple[NoiseComponent, ...]:
    """Return the components of the noise within scans.

    Args:
        parts: The correlated components.
        level: The regression of the scans' noise.
        stated: Standard deviation of a point that the dataset states, or that was assumed [m].
        found: Typical standard deviation of a point [m].
        varies: Whether the level differs from scan to scan.
        off: Whether the stated noise is significantly wrong.
    """
    result = [_correlated(part, found) for part in parts]
    if varies:
        result += _exponents(level)
    if off:
        std = found * 0.5 * float(np.sqrt(level.covariance[0, 0]))
        sentence = f"a point of a scan scatters by {found / MM:.3g} mm about its scan's line, where the dataset states {stated / MM:.3g} mm"
        result.append(NoiseComponent("scan_level", {"stated_mm": stated / MM}, found, std, "m", sentence))
    return tuple(result)


def _correlated(part: Part, found: float) -> NoiseComponent:
    value = found * float(np.sqrt(part.share))
    std = found * part.share_std / (2.0 * float(np.sqrt(part.share)))
    of_surface = part.kernel.of_surface
    either = any(rival.of_surface != of_surface for rival in part.rivals)
    kind = "wavelength" if part.kernel.shape == "waves" else "length"
    if of_surface:
        length, unit = part.length / MM, "mm"
        name, what = (
            "surface_waviness",
            f"the target planes are uneven by {value / MM:.2g} mm over {length:.2g} mm",
        )
    else:
        length, unit = part.length, "points"
        name, what = (
            "scan_correlation",
            f"the scanner's errors at neighbouring points are correlated: they are {value / MM:.2g} mm and extend over {length:.2g} points",
        )
    target: dict[str, Any] = {
        "shape": part.kernel.shape,
        f"{kind}_{unit}": length,
        f"{kind}_std_{unit}": length * part.length_std,
    }
    if either:
        what += "; these data do not distinguish the scanner from the surface"
    return NoiseComponent(name, target, value, std, "m", what)


def _exponents(level: Level) -> list[NoiseComponent]:
    result = []
    std = 0.5 * np.sqrt(np.diag(level.covariance))
    for index, by, words in (
        (1, "range", "the range"),
        (3, "incidence", "the cosine of the incidence (beyond the slant of the rays)"),
    ):
        value = 0.5 * float(level.coefficients[index])
        if abs(value) > _LISTED * std[index]:
            sentence = f"the scanner's noise varies with {words} to the power {value:.2g}"
            result.append(NoiseComponent("scan_level", {"by": by}, value, float(std[index]), "1", sentence))
    return result
