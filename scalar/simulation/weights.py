"""Masses and centres of mass of an arm's links, which effects of gravity need."""

from dataclasses import dataclass

from scalar.simulation.transforms import Array


@dataclass(frozen=True, eq=False)
class Weights:
    """Masses of the n links that move, and of the sensor.

    Attributes:
        masses: (n,) [kg].
        centres: (n, 3) [m], centres of mass, each in its link's frame.
        sensor: mass [kg] of the sensor, at its origin.
    """

    masses: Array
    centres: Array
    sensor: float
