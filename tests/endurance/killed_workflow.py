"""Kill a small run of the workflow at random moments, and call it again.

Each run starts from nothing. After a kill, each result that is there is whole: it has the bytes of an undisturbed run. A plain second call, without
``--unlock`` or ``--rerun-incomplete``, succeeds, gives the same files with the same bytes, and leaves nothing hidden.
"""

from __future__ import annotations

import random
import shutil
import time
from pathlib import Path

from tests.checkouts import copy_checkout, snakemake
from tests.endurance.outcome import HOWS, Outcome
from tests.test_resume import SMALL, TARGETS, contents, killed

ARGUMENTS = (*TARGETS, "--configfile", "configs/small.yaml")


def endure(kills: int, rng: random.Random, root: Path) -> Outcome:
    """Return the outcome of killing the workflow some times, in a copy of the checkout below a folder."""
    whole, disturbed = (copy_checkout(root / name) for name in ("whole", "disturbed"))
    for folder in (whole, disturbed):
        (folder / "configs/small.yaml").write_text(SMALL)
    started = time.monotonic()
    ran = snakemake(whole, *ARGUMENTS)
    length = time.monotonic() - started
    if ran.returncode != 0:
        return Outcome(
            faults=[f"snakemake: undisturbed, it ended with {ran.returncode}: {ran.stdout[-200:]}"]
        )
    expected = contents(whole)
    outcome = Outcome()
    while outcome.kills < kills:
        for name in ("results", ".snakemake"):
            shutil.rmtree(disturbed / name, ignore_errors=True)
        how, whole_group = rng.choice(HOWS), rng.random() < 0.5
        if not killed(disturbed, list(ARGUMENTS), length * rng.uniform(0.05, 1.0), how, whole_group):
            continue
        case = outcome.killed("snakemake", how, whole_group)
        left = {name: sum_ for name, sum_ in contents(disturbed).items() if "/." not in f"/{name}"}
        outcome.partial += 0 < len(left) < len(expected)
        outcome.faults += [
            f"{case}: {name} is not that of an undisturbed run"
            for name, sum_ in left.items()
            if expected.get(name) != sum_
        ]
        ran = snakemake(disturbed, *ARGUMENTS)
        if ran.returncode != 0:
            outcome.faults.append(f"{case}: the second call ended with {ran.returncode}: {ran.stdout[-200:]}")
        elif contents(disturbed) != expected:
            differ = sorted(name for name, _ in contents(disturbed).items() ^ expected.items())
            outcome.faults.append(f"{case}: the second call gave other files or bytes: {', '.join(differ)}")
    return outcome
