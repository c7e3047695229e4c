"""Where the results of one seed lie in the folder of a batch, and how a batch is named."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

_SEED = re.compile(r"seed-(\d+)")
_BATCH = re.compile(r"seeds-(\d+)-(\d+)")


def seed_name(seed: int) -> str:
    """Return the name of a seed's file or folder, ``seed-007``."""
    return f"seed-{seed:03d}"


def batch_names(first: int, count: int, per_batch: int) -> list[str]:
    """Return the names of the batches of `count` seeds from `first` on, ``seeds-001-010`` and so on."""
    starts = range(first, first + count, per_batch)
    return [f"seeds-{start:03d}-{min(start + per_batch, first + count) - 1:03d}" for start in starts]


def batch_seeds(name: str) -> list[int]:
    """Return the seeds of a batch by its name.

    Raises:
        ValueError: The text is no name of a batch.
    """
    match = _BATCH.fullmatch(name)
    if match is None:
        raise ValueError(f"{name!r} is no name of a batch")
    return list(range(int(match[1]), int(match[2]) + 1))


def found_seeds(folder: str | Path) -> Sequence[tuple[int, Path]]:
    """Return (seed, path) of every file or folder in a batch's folder that is named after a seed, sorted by seed."""
    found = [(_SEED.fullmatch(path.stem), path) for path in Path(folder).iterdir()]
    return sorted((int(match[1]), path) for match, path in found if match)
