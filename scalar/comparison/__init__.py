"""What changed in an arm between two calibrations, beyond chance, and by how far each change moves the arm."""

from scalar.comparison.compare import Comparison, compare

__all__ = ["Comparison", "compare"]
