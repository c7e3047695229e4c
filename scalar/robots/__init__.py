"""The library of arms that are sold, one file for each, with the sources of its numbers."""

from scalar.robots.library import LibraryArm, arm_names, largest_payload, read_arm, resembling
from scalar.robots.named_arm import doubt_of_name

__all__ = ["LibraryArm", "arm_names", "doubt_of_name", "largest_payload", "read_arm", "resembling"]
