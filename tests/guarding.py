"""Prove that settings decide: the test that the table of guarding settings names for one fails with it halved, or with it doubled.

    python -m tests.guarding [NAME ...]

The defaults are changed in place, so that whatever reads them sees the other value, and the test is run as it is. It has to pass with the
defaults. If the test passes with the setting halved and doubled, nothing is known to depend on the setting.
"""

from __future__ import annotations

import contextlib
import io
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from study.sensitivity.variants import variants

from scalar.diagnosis.settings import DEFAULTS

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "workflow/resources/guarding_settings.csv"
USUAL = "by default"
QUIET = (
    "-q",
    "-x",
    "-p",
    "no:xdist",
    "-p",
    "no:cacheprovider",
    "-W",
    "ignore::pytest.PytestAssertRewriteWarning",
)


@contextlib.contextmanager
def set_to(name: str, value: float) -> Iterator[None]:
    """Give one of the defaults another value within the block."""
    *groups, last = name.split(".")
    owner = DEFAULTS
    for group in groups:
        owner = getattr(owner, group)
    before = getattr(owner, last)
    object.__setattr__(owner, last, value)  # the settings are frozen dataclasses
    try:
        yield
    finally:
        object.__setattr__(owner, last, before)


def passes(test: str) -> bool:
    """Return whether a test passes, all its parameters.

    Raises:
        RuntimeError: No test has that name.
    """
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = pytest.main([*QUIET, str(ROOT / test)])
    if status not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        raise RuntimeError(f"{test} was not run:\n{said.getvalue()}")
    return status == pytest.ExitCode.OK


def unproven(guards: pd.DataFrame) -> list[str]:
    """Return a line for every setting whose test fails by default, or passes with the setting halved and with it doubled.

    Args:
        guards: Rows of the table.
    """
    faults = [f"{test} fails {USUAL}" for test in guards["test"].unique() if not passes(test)]
    for name, test in zip(guards["setting"], guards["test"], strict=True):
        for variant in variants([name]):
            with set_to(name, variant.value):
                if not passes(test):
                    break
        else:
            faults.append(f"{name}: {test} passes with it halved and with it doubled")
    return faults


def main(names: Sequence[str]) -> int:
    """Print what is not proven, and return 1 if there is anything."""
    guards = pd.read_csv(TABLE)
    wanted: Any = guards[guards["setting"].isin(names)] if names else guards
    faults = unproven(wanted)
    print("\n".join(faults) or f"all {len(wanted)} settings decide")
    return int(bool(faults))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
