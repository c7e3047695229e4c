"""Joint angles at which a calibrated arm stands where it is wanted: the inverse of `predict`."""

from scalar.estimation.correction.correct import (
    Correction,
    brought_near,
    correct_frames,
    correct_joints,
    nearest_to_frames,
)
from scalar.estimation.correction.inverse import arm_length, takes_whole_poses
from scalar.estimation.correction.postures import postures_for
from scalar.estimation.correction.sensitivity import Sensitivity, sensitivity
from scalar.estimation.correction.settings import CorrectionSettings
from scalar.estimation.correction.tables import correct_table

__all__ = [
    "Correction",
    "CorrectionSettings",
    "Sensitivity",
    "arm_length",
    "brought_near",
    "correct_frames",
    "correct_joints",
    "correct_table",
    "nearest_to_frames",
    "postures_for",
    "sensitivity",
    "takes_whole_poses",
]
