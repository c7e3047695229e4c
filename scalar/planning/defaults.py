"""Default values of a plan."""

from scalar.units import MM

REPEATABILITY = 0.02 * MM
"""Standard deviation along each axis with which an arm repeats a position [m]."""
N_CANDIDATES = 1200
"""Number of candidate poses from which a plan is chosen."""
PLANNED_POSES = 60
"""Number of poses of a plan that is not made after a diagnosis."""
FURTHER_POSES = 20
"""Number of poses that are added after a diagnosis."""
