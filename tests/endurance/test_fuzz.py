"""Every reader survives files damaged at random: what it cannot read it refuses in sentences. `python -m tests.endurance.fuzz` is the long run."""

import random
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.endurance.fuzz import Fuzzed, TooLong, patience
from tests.endurance.readers import READERS, Reader

INPUTS = 50
LONG = ("dataset, calibrated",)
"""Readers that take a second for an input: of the long run alone."""


@pytest.fixture(scope="module", params=[name for name in READERS if name not in LONG])
def fuzzed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Fuzzed:
    """Return the good files of each reader."""
    if request.param == "scene":
        pytest.importorskip("pybullet")
    return Fuzzed(READERS[request.param], tmp_path_factory.mktemp("fuzzed") / "files")


def keep(config: pytest.Config, find: str) -> None:
    """Append a find to .pytest_cache/d/fuzz/finds.txt, since the message of a failure that comes at random is easily lost."""
    with (config.cache.mkdir("fuzz") / "finds.txt").open("a") as file:
        file.write(f"{find}\n")


@settings(max_examples=INPUTS, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**63))
def test_a_damaged_file_is_refused_or_read_as_what_it_says(
    fuzzed: Fuzzed, pytestconfig: pytest.Config, seed: int
) -> None:
    """A file with changed bytes, lines, words or parts is either refused with a printable message or read, in bounded time and memory."""
    find = fuzzed.one(random.Random(seed))
    if find is not None:
        keep(pytestconfig, f"{fuzzed.reader.name}, seed {seed}: {find}")
    assert find is None


def test_the_message_of_a_find_names_the_error_and_the_kept_file(tmp_path):
    """The message of a find names the error and the file with the bytes that caused it, which the next input does not replace."""

    def read(folder: Path) -> str:
        if (folder / "a.txt").read_text(errors="replace") != "sound":
            raise RuntimeError("nobody foresaw this")
        return "sound"

    fuzzed = Fuzzed(Reader("text", lambda folder: _write(folder / "a.txt"), read), tmp_path / "files")
    rng = random.Random(1)
    find = next(found for found in (fuzzed.one(rng) for _ in range(100)) if found)
    assert "RuntimeError in test_fuzz.py" in find and "nobody foresaw this" in find
    kept = Path(find.split("kept as ")[1])
    assert kept.read_text(errors="replace") != "sound"
    assert fuzzed.row()["finds"] == 1


def test_the_time_limit_is_of_processor_time():
    """An endless loop is ended, and an input does not count as slow because the machine is busy with other work."""
    with pytest.raises(TooLong), patience(1):
        while True:
            pass
    with patience(1):
        time.sleep(1.2)


def _write(path: Path) -> None:
    path.write_text("sound")
