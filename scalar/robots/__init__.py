"""The library of arms that are sold, one file for each, with the sources of its numbers."""

from scalar.robots.library import LibraryArm, arm_names, largest_payload, read_arm, resembling

__all__ = ["LibraryArm", "arm_names", "largest_payload", "read_arm", "resembling"]
