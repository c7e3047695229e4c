"""The set-up by `make env`: what it refuses, and what it takes for finished."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture
def bare_clone(tmp_path: Path) -> Path:
    """Return a folder, with a blank in its path, that holds what `make env` reads."""
    clone = tmp_path / "a clone"
    for name in ("Makefile", "pyproject.toml", "requirements", "scalar/__init__.py"):
        source, target = ROOT / name, clone / name
        target.parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if source.is_dir() else shutil.copy)(source, target)
    return clone


def fake_python(folder: Path, version: str) -> Path:
    """Write a `python3` of the wrong version: it answers a program that prints, and fails one that checks."""
    folder.mkdir()
    executable = folder / "python3"
    executable.write_text(
        f'#!/bin/sh\ncase "$2" in *venv*) exit 1;; *) echo "python3 is {version}";; esac\n', encoding="utf-8"
    )
    executable.chmod(0o755)
    return executable


def make(clone: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    return subprocess.run(
        ["make", "--no-print-directory", *arguments],
        cwd=clone,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(("version", "said"), [("3.12.1", "python3 is 3.12.1"), (None, "no Python")])
def test_wrong_python_is_one_clear_line(
    bare_clone: Path, tmp_path: Path, version: str | None, said: str
) -> None:
    """Without Python 3.11 `make` touches nothing and fails, in one line: what is needed, what was found."""
    python = fake_python(tmp_path / "bin", version) if version else tmp_path / "bin" / "python3"
    run = make(bare_clone, "env", f"PYTHON={python}")
    assert run.returncode != 0
    (line,) = (run.stdout + run.stderr).splitlines()
    assert "needs Python 3.11" in line
    assert said in line
    assert not (bare_clone / ".venv").exists()


def test_half_built_environment_is_not_taken_for_complete(bare_clone: Path) -> None:
    """An environment without its stamp is built again; with it, `make env` has nothing to do."""
    (bare_clone / ".venv" / "bin").mkdir(parents=True)
    assert make(bare_clone, "--question", "env").returncode == 1
    for stamp in (".locked", ".installed"):
        (bare_clone / ".venv" / stamp).touch()
    assert make(bare_clone, "--question", "env").returncode == 0
