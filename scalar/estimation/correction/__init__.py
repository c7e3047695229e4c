"""Joint angles at which a calibrated arm stands where it is wanted: the inverse of `predict`."""

from scalar.estimation.correction.correct import Correction, correct_frames, correct_joints, kept_as_given
from scalar.estimation.correction.postures import postures_for
from scalar.estimation.correction.sensitivity import Sensitivity, sensitivity
from scalar.estimation.correction.settings import CorrectionSettings
from scalar.estimation.correction.tables import correct_table

__all__ = [
    "Correction",
    "CorrectionSettings",
    "Sensitivity",
    "correct_frames",
    "correct_joints",
    "correct_table",
    "kept_as_given",
    "postures_for",
    "sensitivity",
]
