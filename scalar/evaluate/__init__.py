"""Errors of a calibration: against the truth of a simulated dataset, and estimated over the workspace (``workspace_errors``)."""

from scalar.evaluate.pose_errors import (
    Evaluation,
    PoseErrors,
    aligned_to,
    best_rigid_motion,
    evaluate,
    pose_errors,
    rotation_vector_near,
    true_frames,
)
from scalar.evaluate.truth import read_truth

__all__ = [
    "Evaluation",
    "PoseErrors",
    "aligned_to",
    "best_rigid_motion",
    "evaluate",
    "pose_errors",
    "read_truth",
    "rotation_vector_near",
    "true_frames",
]
