"""One coordinate of measured positions too long or too short, as where its scale was set wrongly in an instrument or a table.

A factor on all coordinates is one on all lengths of the arm, and is said to be that. A factor on one of them fits no arm, but effects of an arm may
come near to it: in a simulated campaign whose z was 0.2 % too long a scale error of joint 2 had been named with a confidence of 0.96.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.displacement import projected_out
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.setup.suspicion import Suspicion
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.units import MM

STRETCHED_AXIS = "stretched_axis"  # as a suspicion names it
_LEAST_STRETCH = 5e-4  # m per m, chosen: no instrument in use errs by as much in one of its coordinates
# Of the squared residual, chosen: in some two hundred campaigns with other errors of arms, simulated and measured, the largest share was 0.49.
_LEAST_SHARE = 0.65
_STEP = 1e-4  # of the difference by which the derivative is taken
_NULL = 1e-12  # of the largest singular value: directions with a smaller one are not determined


@dataclass(frozen=True)
class StretchedAxis:
    """The coordinate whose scale explains a residual best.

    Attributes:
        axis: ``x``, ``y`` or ``z``.
        stretch: By which share the measured coordinate is too long; negative if it is too short.
        share: Of the squared residual that it explains.
    """

    axis: str
    stretch: float
    share: float


def stretched_axis(dataset: Dataset, model: Model, free: Array) -> StretchedAxis | None:
    """Return which measured coordinate has another scale, if that explains nearly all of the residual of a rigid fit; else None.

    Args:
        dataset: What was measured.
        model: The fit, without effects.
        free: ``(P,)`` bool, its free parameters.
    """
    if not kind_of(dataset).measures_positions or model.effects:
        return None
    residual, jacobian = Residuals.of(dataset, model).linearise(model)
    scaled = [replace(dataset, points=_scaled(dataset.points, k, 1.0 + _STEP)) for k in range(3)]
    columns = [(Residuals.of(one, model).linearise(model)[0] - residual) / _STEP for one in scaled]
    known = jacobian[:, free] / np.maximum(np.linalg.norm(jacobian[:, free], axis=0), 1e-300)
    left, *own_columns = projected_out(known, np.column_stack([residual, *columns]), _NULL).T
    found = []
    for axis, own in zip("xyz", own_columns, strict=True):
        size = float(own @ own)
        stretch = float(own @ left) / size if size > 0.0 else 0.0
        found.append(StretchedAxis(axis, stretch, stretch * stretch * size / max(float(left @ left), 1e-300)))
    best = max(found, key=lambda one: one.share)
    return best if best.share >= _LEAST_SHARE and abs(best.stretch) >= _LEAST_STRETCH else None


def _scaled(points: Array, k: int, factor: float) -> Array:
    """Return points ``(P, 3)`` with one coordinate multiplied by a factor."""
    changed = points.copy()
    changed[:, k] *= factor
    return changed


def stretched_axis_in_words(dataset: Dataset, model: Model, free: Array) -> list[Suspicion]:
    """Return the suspicion that one measured coordinate has another scale (``stretched_axis``); none if that explains too little."""
    found = stretched_axis(dataset, model, free)
    if found is None:
        return []
    file = kind_of(dataset).format.measured_in
    size, longer = abs(100 * found.stretch), "long" if found.stretch > 0 else "short"
    displaced = abs(found.stretch) * float(np.std(dataset.points[:, "xyz".index(found.axis)]))
    return [
        Suspicion(
            STRETCHED_AXIS,
            file,
            f"{100 * found.share:.0f} % of the squared residual goes away if {found.axis} of {file} is {size:.2g} % too {longer}: no arm errs so. "
            "Look at the scale of the instrument along this axis, and at the factor with which this column was written. Until that is settled, "
            f"reckon with {displaced / MM:.2g} mm beside the stated errors: by so much does such a factor displace the measured positions (RMS)",
        )
    ]
