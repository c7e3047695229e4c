"""How far the positions that ``after.json`` predicts are expected to err: root mean square over random poses, with a 95 % band.

The errors by which models are chosen (``nested_models``) leave out what all models lack, because it does not distinguish them. The errors that are
stated here count it as far as it is known (``discrepancy_of_fit``), besides the chance errors of the fit. Only the place of the base is fitted to
the predictions; the shift of the sensor is that of the calibration.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from scalar.diagnosis.accuracy.discrepancy_of_fit import discrepancy_of_shipped
from scalar.diagnosis.accuracy.excess_residual import Shipping
from scalar.diagnosis.accuracy.stated_errors import of_halves
from scalar.diagnosis.fit.predicted_displacements import joint_limits, measured_ranges, poses_within
from scalar.diagnosis.held_out.outer_split import OuterSplit
from scalar.diagnosis.shipping.nested_models import LIMITS, RANGES
from scalar.evaluate.workspace_errors import Banded, rms_over_poses, workspace_errors
from scalar.units import MM

# Number of random poses: their mean square then varies by a few per cent from one choice of them to another.
_N_POSES = 400
_SHIPPED = "after.json"


@dataclass(frozen=True)
class ExpectedErrors:
    """Expected errors of the positions that ``after.json`` predicts [m], root mean square over poses.

    Attributes:
        within_limits: At random poses within the joint limits.
        within_ranges: At random poses within the ranges of the joints that were measured.
        has_bands: Whether they have bands; without a covariance, both ends are the number itself.
    """

    within_limits: Banded
    within_ranges: Banded
    has_bands: bool = True

    def to_mapping(self) -> dict[str, object]:
        """Return the numbers and their bands as they stand in ``diagnosis.json``."""
        return {
            key: value
            for name, error in (
                ("as_shipped_within_measured_ranges", self.within_ranges),
                ("as_shipped_within_joint_limits", self.within_limits),
            )
            for key, value in (
                (name, error.value / MM),
                (f"{name}_band", [error.low / MM, error.high / MM] if self.has_bands else None),
            )
        }


@lru_cache(maxsize=1)
def expected_errors(diagnosis: Shipping) -> ExpectedErrors:
    """Return how far the positions that ``after.json`` predicts are expected to err."""
    calibration, state = diagnosis.calibration_after, diagnosis.shipped_state
    discrepancy = discrepancy_of_shipped(diagnosis)
    found = []
    for ranges in (joint_limits(state), measured_ranges(state)):
        errors = workspace_errors(
            calibration,
            {_SHIPPED: calibration.model},
            poses_within(ranges, state, _N_POSES),
            discrepancy,
            sensor_fitted=False,
        )
        if errors is not None:
            found.append(errors.sizes(_SHIPPED).banded(rms_over_poses))
    if len(found) == 2:
        return ExpectedErrors(*found)
    compared = diagnosis.shipped.choice.expected_errors(without_effects=diagnosis.shipped.without_effects)
    within_limits, within_ranges = (Banded(*3 * (compared[k],)) for k in (LIMITS, RANGES))
    return ExpectedErrors(within_limits, within_ranges, has_bands=False)


def shipped_entry(diagnosis: Shipping, halves: OuterSplit | None) -> dict[str, Any]:
    """Return the entry of ``diagnosis.json`` on the fit that is shipped, on the errors that are expected of it, and on the halves of the poses."""
    entry: dict[str, Any] = diagnosis.shipped.to_mapping() | {"halves": of_halves(halves)}
    expected: dict[str, object] = entry["expected_error_mm"]
    return entry | {"expected_error_mm": expected | expected_errors(diagnosis).to_mapping()}
