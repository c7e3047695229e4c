"""Two `make` in one checkout: the second waits, and then finds that its work is done; a killed one leaves no lock behind.

A stand-in takes the place of Python: it logs what it is asked to set up, takes a while, and fills an environment with itself.
"""

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
STEP = 0.3  # s that a step of the stand-in takes
STAND_IN = f"""#!/bin/sh
case "$1 $2" in
    "-c "*) echo "$0"; exit 0;;  # asked for its version: it suits
    "-m venv") step=venv;;
    "-m pip") step=pip;;
    "-m compileall") exit 0;;
    *) step=uv;;
esac
echo "begin $step" >> steps.log
sleep {STEP}
if [ $step = venv ]; then mkdir -p .venv/bin; cp "$0" .venv/bin/python; cp "$0" .venv/bin/uv; fi
echo "end $step" >> steps.log
"""
STEPS = ["venv", "pip", "uv", "pip"]  # the environment, uv, the lock, and this package

pytestmark = pytest.mark.skipif(
    shutil.which("flock") is None, reason="without flock, as on macOS, two `make` do not wait for each other"
)


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """Return a folder that holds what `make env` reads, with a stand-in for Python."""
    for name in ("Makefile", "pyproject.toml", "hatch_build.py", "requirements", "scalar/__init__.py"):
        source, target = ROOT / name, tmp_path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if source.is_dir() else shutil.copy)(source, target)
    (tmp_path / "python3.11").write_text(STAND_IN, encoding="utf-8")
    (tmp_path / "python3.11").chmod(0o755)
    return tmp_path


def started(clone: Path) -> subprocess.Popen[str]:
    """Start `make env` in a process group of its own."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    return subprocess.Popen(
        ["make", "--no-print-directory", "env", f"PYTHON={clone}/python3.11"],
        cwd=clone,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def steps(clone: Path) -> list[str]:
    """Return the lines that the stand-in logged."""
    log = clone / "steps.log"
    return log.read_text(encoding="utf-8").splitlines() if log.exists() else []


def wait_for(clone: Path, line: str) -> None:
    """Wait until the stand-in has logged a line."""
    for _ in range(600):
        if line in steps(clone):
            return
        time.sleep(0.05)
    pytest.fail(f"'{line}' was never logged: {steps(clone)}")


def test_two_makes_build_one_environment(clone: Path) -> None:
    """Both succeed, each step is made once, and none begins within another."""
    both = [started(clone), started(clone)]
    for process in both:
        said, _ = process.communicate(timeout=120)
        assert process.returncode == 0, said
    assert steps(clone) == [f"{when} {step}" for step in STEPS for when in ("begin", "end")]


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_a_killed_make_is_made_good(clone: Path, how: signal.Signals) -> None:
    """After a `make` was killed within a step, a plain second one builds everything from nothing and does not wait for the dead."""
    first = started(clone)
    wait_for(clone, "begin uv")
    os.killpg(first.pid, how)
    first.communicate(timeout=60)
    before = len(steps(clone))
    second = started(clone)
    said, _ = second.communicate(timeout=120)
    assert second.returncode == 0, said
    assert steps(clone)[before:] == [f"{when} {step}" for step in STEPS for when in ("begin", "end")]


def test_a_third_make_has_nothing_to_do(clone: Path) -> None:
    """When the environment stands, `make env` makes no step."""
    for _ in range(2):
        process = started(clone)
        said, _ = process.communicate(timeout=120)
        assert process.returncode == 0, said
    assert len(steps(clone)) == 2 * len(STEPS)
