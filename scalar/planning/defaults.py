"""What a plan takes where nothing else is said."""

from scalar.units import MM

REPEATABILITY = 0.02 * MM
"""Of an arm, one standard deviation along each axis [m]."""
N_CANDIDATES = 1200
"""How many poses to choose from."""
FURTHER_POSES = 20
"""How many poses are added after a diagnosis."""
