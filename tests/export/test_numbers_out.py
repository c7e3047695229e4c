"""Numbers in exported files."""

import numpy as np
import pytest
import yaml

from scalar.export.numbers_out import shortest


@pytest.mark.parametrize("value", [0.2363, -1e-5, 3.0, np.float64(0.1) + 0.2, 1.5e-17, np.pi])
def test_a_number_reads_back_exactly_and_is_no_longer_than_needed(value):
    """No shorter text of digits reads back as the same number."""
    text = shortest(value)
    assert float(text) == value and len(text) <= len(f"{value:.17g}")


def test_zero_has_no_sign():
    assert shortest(-0.0) == "0"
    assert yaml.safe_load(shortest(0.2363)) == 0.2363
