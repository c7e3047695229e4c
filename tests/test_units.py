"""The units are what their names say."""

import math

from scalar.units import DEG, MM


def test_a_thousand_millimetres_are_a_metre() -> None:
    """1000 mm = 1 m."""
    assert 1000 * MM == 1.0


def test_half_a_turn_is_pi() -> None:
    """180 degrees = pi rad, and dividing by the unit undoes multiplying by it."""
    assert 180 * DEG == math.pi
    assert math.isclose(37.5 * DEG / DEG, 37.5, rel_tol=1e-15)
