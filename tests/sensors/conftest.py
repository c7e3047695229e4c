"""Fixtures of the tests of sensors."""

import numpy as np
import pytest


@pytest.fixture
def rng():
    """Return a generator that each test has to itself."""
    return np.random.default_rng(20261122)
