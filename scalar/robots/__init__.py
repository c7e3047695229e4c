"""The library of arms that are sold, one file for each, with the sources of its numbers."""

from scalar.robots.axis_names import axis_in_brackets, axis_names_of
from scalar.robots.library import (
    LibraryArm,
    arm_names,
    has_arm,
    largest_payload,
    read_arm,
    resembling,
    similar_names,
)
from scalar.robots.named_arm import arms_in_proportion, arms_with_axes_of, doubt_of_name

__all__ = [
    "LibraryArm",
    "arm_names",
    "arms_in_proportion",
    "arms_with_axes_of",
    "axis_in_brackets",
    "axis_names_of",
    "doubt_of_name",
    "has_arm",
    "largest_payload",
    "read_arm",
    "resembling",
    "similar_names",
]
