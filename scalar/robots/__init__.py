"""Arms that people own: a file each, with the sources of its numbers."""

from scalar.robots.library import LibraryArm, arm_names, read_arm

__all__ = ["LibraryArm", "arm_names", "read_arm"]
