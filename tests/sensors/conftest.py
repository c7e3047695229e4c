"""Fixtures of the tests of sensors."""

import numpy as np
import pytest


@pytest.fixture
def rng():
    """Return a fresh generator with a fixed seed for each test."""
    return np.random.default_rng(20261122)
