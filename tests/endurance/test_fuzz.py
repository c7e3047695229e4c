"""Every reader survives files damaged at random: what it cannot read it refuses in sentences. `python -m tests.endurance.fuzz` is the long run."""

import random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.endurance.fuzz import Fuzzed
from tests.endurance.readers import READERS

INPUTS = 50


@pytest.fixture(scope="module", params=READERS)
def fuzzed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Fuzzed:
    """Return the good files of each reader."""
    if request.param == "scene":
        pytest.importorskip("pybullet")
    return Fuzzed(READERS[request.param], tmp_path_factory.mktemp("fuzzed") / "files")


@settings(max_examples=INPUTS, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**63))
def test_a_damaged_file_is_refused_or_read_as_what_it_says(fuzzed: Fuzzed, seed: int) -> None:
    """Bytes, lines, words and parts of a tree changed: a refusal that can be printed, or an answer, in bounded time and memory."""
    assert fuzzed.one(random.Random(seed)) is None
