"""Calibrate: from a dataset to robot, sensor, target and effects with their standard errors.

The one objective is the squared whitened residual of ``scalar.estimation.residuals``; robot, sensor, target and effects are fitted together.
The parameters that the data do not determine are derived for the robot and the poses at hand (``scalar.estimation.identifiability``)
and fixed; no list of them is kept.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.data.dataset import Dataset
from scalar.effects.effect import Effect
from scalar.errors import Fault, InvalidInput, NotConverged, Undetermined
from scalar.estimation.conclude import conclude
from scalar.estimation.gross_errors import clean
from scalar.estimation.joint_fit import fit_all
from scalar.estimation.prepare import GROSS_ERROR, prepare
from scalar.estimation.result import Calibration
from scalar.units import MM


def calibrate(
    dataset: Dataset,
    *,
    effects: Sequence[Effect] = (),
    fixed_effects: Sequence[Effect] = (),
    fix: Sequence[str] = (),
) -> Calibration:
    """Return the calibration of a dataset: robot, sensor, target and effects at once.

    Args:
        dataset: What was measured.
        effects: To estimate, from where their coefficients stand.
        fixed_effects: To apply as they are.
        fix: Further parameters to fix at their nominal values, by name.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: The data cannot determine the model, or the fit did not converge.
    """
    prepared = prepare(dataset, fix)
    try:
        found, residuals = fit_all(dataset, prepared, effects, fixed_effects)
    except NotConverged:
        _refuse_gross_errors(dataset)
        raise
    squares, counts = residuals.squared_distances(found.model)
    distances = np.sqrt(squares / counts)
    if distances.max() > GROSS_ERROR:
        _refuse_gross_errors(dataset)
    if distances.max() > GROSS_ERROR:
        worst = int(dataset.pose_ids[np.argmax(distances)])
        raise Undetermined(
            [f"the best fit is still {residuals.rms(found.model) / MM:.0f} mm RMS off, pose {worst} most of all: this is not "
             "the robot, the sensor or the planes that dataset.yaml describes; check conventions, units and plane labels; "
             "'scalar diagnose' can say more"]
        )  # fmt: skip
    return conclude(dataset, prepared, found, residuals)


def _refuse_gross_errors(dataset: Dataset) -> None:
    """Refuse a dataset with poses that contradict the rest, naming them.

    Raises:
        InvalidInput: Poses lie on another plane than said, or on none.
        Undetermined: So many contradict each other that none can be trusted.
    """
    cleaned = clean(dataset)
    rows = {int(pose): row for row, pose in enumerate(dataset.pose_ids)}
    faults = [
        Fault(
            "poses.csv",
            f"pose {pose} is said to lie on '{dataset.poses['plane'].iloc[rows[pose]]}' and lies on '{plane}': correct its plane",
            None,
            "plane",
        )
        for pose, plane in cleaned.mislabelled_poses
    ]
    faults += [
        Fault(
            "poses.csv",
            f"pose {pose} contradicts all others: remove it, or let 'scalar diagnose' set it aside",
            None,
            "pose",
        )
        for pose in cleaned.outlier_poses
    ]
    if faults:
        raise InvalidInput(faults)
