"""Numbers with a sign between thousands are said to be that, and how to write them; what may have a decimal sign there is not."""

import pytest

from scalar.data.io.grouped_digits import remedy_of_groups


@pytest.mark.parametrize(
    ("cell", "left_out", "meant"),
    [
        ("1.010,5", "points", "1010.5"),
        ("-12,010.25", "commas", "-12010.25"),
        ("1.234.567", "points", "1234567"),
        ("1'234.5", "apostrophes", "1234.5"),
        ("12 345", "blanks", "12345"),
    ],
)
def test_a_sign_between_thousands_is_named(cell, left_out, meant):
    """The remedy names the sign that has to go, and the number as it is read."""
    said = remedy_of_groups(cell)
    assert said is not None and f"the {left_out} between thousands: write {meant}" in said


@pytest.mark.parametrize(
    "cell", ["1,010", "1.010", "10,5", "0,123", "0.123,4", "1.01,5", "1,010,5", "12", "a", ""]
)
def test_what_may_be_a_decimal_sign_is_left_to_its_own_message(cell):
    """One sign before three digits may begin decimals."""
    assert remedy_of_groups(cell) is None
