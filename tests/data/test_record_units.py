"""Records in another unit than the format's are asked about; usual ones are not."""

import numpy as np
import pytest

from scalar.data.record_units import units_suspected

MINUTES = 60.0 * np.arange(20)


@pytest.mark.parametrize(
    ("column", "values", "word"),
    [
        ("payload", np.array([0.0, 2500.0]), "grams"),
        ("payload_x", np.array([0.0, -50.0]), "millimetres"),
        ("temperature", np.array([68.0, 86.0]), "Fahrenheit"),
        ("temperature", np.array([293.0, 301.0]), "kelvin"),
        ("time", 1000.0 * MINUTES, "milliseconds"),
        ("time", 46146.375 + MINUTES / 86400.0, "days"),
    ],
)
def test_a_record_in_another_unit_is_asked_about(column, values, word):
    """The clause names the unit that may be meant."""
    (clause,) = units_suspected({column: values})
    assert clause.startswith(column) and word in clause


@pytest.mark.parametrize(
    "columns",
    [
        {
            "payload": np.array([0.0, 500.0]),
            "payload_z": np.array([0.0, 0.3]),
            "temperature": np.array([-5.0, 45.0]),
            "time": MINUTES,
        },
        {"temperature": np.array([np.nan, 22.0]), "time": np.array(["a", "b"], dtype=object)},
        {"time": np.r_[MINUTES, 1e6 + MINUTES]},  # two days
        {},
    ],
)
def test_a_usual_record_is_not(columns):
    """Nor is one that is empty, holds words, or has a long break."""
    assert units_suspected(columns) == []
