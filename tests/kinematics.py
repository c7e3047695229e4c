"""Forward kinematics for tests: the elementary matrices of the studies, which call nothing of ``scalar``."""

from study.common.kinematics import (
    PARAMETER_KINDS,
    best_motion,
    chain,
    joint_names,
    pose_mapping,
    random_transform,
    rotate_about,
    rotation,
    rotation_vector,
    standard_chain,
    transform,
    translation,
)

__all__ = [
    "PARAMETER_KINDS",
    "best_motion",
    "chain",
    "joint_names",
    "pose_mapping",
    "random_transform",
    "rotate_about",
    "rotation",
    "rotation_vector",
    "standard_chain",
    "transform",
    "translation",
]
