"""What the models of two calibrations lack, for the terminal: it may look like a change of the arm."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from scalar.cli.compared_effects import how_effects_differ
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.comparison import Comparison

_MISFIT = 1e-3  # p-value below which the residual is larger than the noise explains, so that the model lacks something


def notes_on_models(comparison: Comparison, residuals: Mapping[str, float]) -> list[str]:
    """Return the notes on what the models lack and on how the effects and the names of the arms differ.

    Args:
        comparison: The comparison.
        residuals: The residual [m] of A or B by letter, where it is more than instruments of the kind scatter by, and no noise is known.
    """
    notes = [
        f"note: the model of {letter} leaves {ratio:.1f} times its noise; what it lacks may look like a change (`scalar diagnose` looks for it)"
        for letter, (ratio, p) in zip("AB", comparison.misfits, strict=True)
        if p < _MISFIT
    ]
    notes += [
        f"note: the model of {letter} leaves {rms / MM:.3f} mm RMS, which is more than noise; what it lacks may look like a change, or hide one "
        "(`scalar diagnose` looks for it)"
        for letter, rms in residuals.items()
    ]
    if (i := comparison.noisier) is not None and "AB"[i] not in residuals:
        more, less = comparison.residuals[i] / MM, comparison.residuals[1 - i] / MM
        notes.append(
            f"note: the model of {'AB'[i]} leaves {more:.3f} mm RMS, and that of {'BA'[i]} {less:.3f} mm; unless its instrument was worse "
            "(then state noise in both dataset.yaml), it lacks something that the other does not, such as the error of a damaged gear, and that may "
            "look like a change (`scalar diagnose` looks for it)"
        )
    if comparison.arm.effects_differ:
        notes.append(how_effects_differ(comparison))
    if "names" in comparison.campaign:
        one, other = comparison.campaign["names"]
        notes.append(f"note: A calls the arm '{one}' and B '{other}'; the nominal geometry is the same")
    return notes


def is_lacking(comparison: Comparison, residuals: Mapping[str, float]) -> bool:
    """Return whether a model lacks something: its parameters then depend a little on the measured poses, and differ without any change of the arm."""
    misfit = any(p < _MISFIT for _, p in comparison.misfits)
    return misfit or bool(residuals) or comparison.noisier is not None
