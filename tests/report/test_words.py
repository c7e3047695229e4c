"""The words of the report: each number reads back as the value, in the unit that is printed next to it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.effects import wording
from scalar.report import words


@pytest.mark.parametrize(
    ("name", "value", "written", "unit"),
    [
        ("gain_rad_per_rad", 2.5e-3, "2.50", "mrad/rad"),
        ("gain_m_per_m", 2.5e-3, "2.50", "mm/m"),
        ("offset_m", 2.5e-3, "2.50", "mm"),
        ("beta_rad", 0.017453292519943295, "1.00", "°"),
    ],
)
def test_a_coefficient_stands_in_the_unit_beside_it(name: str, value: float, written: str, unit: str) -> None:
    """A coefficient in SI units is written in the unit of the table's last column."""
    row = words.coefficient(name, value, None)
    assert (row[1], row[3]) == (written, unit)


@pytest.mark.parametrize(
    ("name", "words_for_it"),
    [
        ("frame2_x_rad", "tilt by the masses along x of frame 2"),
        ("joint2_frame3_y_rad", "joint 2 by the weight of link 3 along y, at its longest lever"),
    ],
)
def test_what_is_fitted_for_the_masses_of_links_is_said_in_words(name: str, words_for_it: str) -> None:
    """The line on the terminal says what the coefficient is, as the table of the report does."""
    assert words.coefficient(name, 1e-4, None)[0] == words_for_it


def test_milliradians_do_not_depend_on_the_unit_of_length(monkeypatch: pytest.MonkeyPatch) -> None:
    """Milliradians are thousandths, and would be so even if lengths were written in inches."""
    before = words.coefficient("gain_rad_per_rad", 2.5e-3, 1e-4)
    monkeypatch.setattr(wording, "MM", 25.4e-3)
    assert words.coefficient("gain_rad_per_rad", 2.5e-3, 1e-4) == before
    assert words.coefficient("gain_m_per_m", 2.5e-3, 1e-4) != words.coefficient(
        "gain_rad_per_rad", 2.5e-3, 1e-4
    )


@given(st.floats(-1e12, 1e12, allow_nan=False), st.integers(2, 6))
def test_numbers_read_back(value: float, digits: int) -> None:
    """A number that is written for people is the number, to the digits that are shown."""
    text = words.number(value, digits).replace("−", "-")
    if "×" in text:
        mantissa, power = text.split(" × 10")
        ordinary = power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
        back = float(mantissa) * 10.0 ** int(ordinary)
    else:
        back = float(text)
    assert back == pytest.approx(value, rel=0.6 * 10.0 ** (1 - digits))


@pytest.mark.parametrize(
    ("value", "std", "shown"),
    [
        (-3.28e-5, 1.7e-3, ("0.0000", "0.0017")),
        (12.345678, 1.2e-3, ("12.3457", "0.0012")),
        (-0.4, 30.0, ("0", "30")),
        (1e-9, 3e-7, ("1.00 × 10⁻⁹", "3.0 × 10⁻⁷")),
        (5.0, 0.0, ("5.00", "0")),
    ],
)
def test_a_number_has_as_many_decimals_as_its_error(value, std, shown):
    """The standard error has two significant digits, and the number ends at the same decimal; zero has no sign."""
    assert wording.with_error(value, std) == shown
