"""Batches split the seeds without loss, and find their way back from names."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from study.common.seeds import batch_names, batch_seeds, found_seeds, seed_name


@given(st.integers(0, 2000), st.integers(1, 200), st.integers(1, 60))
def test_batches_partition_the_seeds(first, count, per_batch):
    """Every seed is in exactly one batch, in order, and no batch has more seeds than asked for."""
    batches = [batch_seeds(name) for name in batch_names(first, count, per_batch)]
    assert [seed for batch in batches for seed in batch] == list(range(first, first + count))
    assert max(map(len, batches)) <= per_batch


def test_what_is_not_a_seed_is_passed_over(tmp_path):
    """Snakemake's own time stamp in a folder is no seed; seeds come sorted by number, not by name."""
    for seed in (1000, 7, 20):
        (tmp_path / f"{seed_name(seed)}.json").touch()
    (tmp_path / ".snakemake_timestamp").touch()
    assert [seed for seed, _ in found_seeds(tmp_path)] == [7, 20, 1000]


def test_a_name_of_something_else_is_no_batch():
    """A wrong name is refused, not misread."""
    with pytest.raises(ValueError, match="seed-001"):
        batch_seeds("seed-001")
