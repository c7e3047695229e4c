"""Say whether a diagnosis had too few poses to find effects, and how many more would suffice.

In a small campaign the geometry alone has nearly as many parameters as there are equations. Few degrees of freedom are then left to identify an
effect, and it looks like a scatter of the poses: a compliance that is named with 60 scans is taken for a scatter with 36.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scalar.diagnosis.held_out.repetitions import distinct_poses
from scalar.diagnosis.naming.two_halves import EQUATIONS_FOR_EFFECTS

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis


def few_poses(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence that the poses are too few to find effects, if nothing certain was found; nothing if the poses suffice."""
    if any(finding.has_name and not finding.doubtful for finding in diagnosis.findings):
        return []
    measurement, distinct = diagnosis.after.residuals.measurement, distinct_poses(diagnosis.after)
    equations, unknowns = int(measurement.equations[distinct].sum()), len(diagnosis.calibration_before.free)
    if equations >= EQUATIONS_FOR_EFFECTS * unknowns:
        return []
    more = int(np.ceil((EQUATIONS_FOR_EFFECTS * unknowns - equations) / measurement.equations_per_pose))
    poses = f"{distinct.sum()}" if distinct.all() else f"{distinct.sum()} different ones"
    called = (
        "what is called a scatter here may be an effect"
        if diagnosis.reported_noise
        else "effects may be hidden"
    )
    return [
        f"Too few poses: {poses} give {equations} equations for {unknowns} parameters of arm, sensor and {measurement.target_words}, hardly enough "
        f"to distinguish effects of the arm from a scatter of its poses, so {called}. Measure at least {more} more ('scalar plan WORKCELL --near "
        f"before.json --poses {more} -o plan' chooses them), and diagnose all poses together."
    ]
