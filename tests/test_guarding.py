"""The tests of settings that no blind set puts to the test: each fails with its setting halved, or with it doubled."""

import os
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from scalar.diagnosis.settings import DEFAULTS
from tests import guarding

ROOT = Path(__file__).parents[1]
HARMLESS = "tests/test_units.py::test_units_are_converted_by_the_constants_of_one_file"


@pytest.mark.slow
def test_every_guarding_test_fails_with_its_setting_changed():
    """Each guarding test fails with its setting halved or doubled, which is tried in another process because it changes the defaults."""
    paths = os.pathsep.join([str(ROOT), str(ROOT / "workflow")])
    ended = subprocess.run(
        [sys.executable, "-m", "tests.guarding"],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_a_test_that_passes_whatever_a_setting_is_proves_nothing(monkeypatch):
    """A test that never fails is named, by default and with the setting changed; the setting is what it was afterwards."""
    seen = []
    monkeypatch.setattr(guarding, "passes", lambda test: seen.append(DEFAULTS.selection.swap_margin) or True)
    guards = pd.DataFrame({"setting": ["selection.swap_margin"], "test": [HARMLESS]})
    (fault,) = guarding.unproven(guards)
    assert fault.startswith(f"selection.swap_margin: {HARMLESS} passes")
    assert seen == [3.0, 1.5, 6.0] and DEFAULTS.selection.swap_margin == 3.0
    monkeypatch.setattr(guarding, "passes", lambda test: DEFAULTS.selection.swap_margin < 5.0)
    assert not guarding.unproven(guards)
