"""The set-up by `make env`: what it refuses, and what it takes for finished."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
STAMPS = (".locked", ".installed", ".compiled")  # in the order in which `make env` sets them
CHECKED_HASH = 0b11  # flags in bytecode that is checked against a hash of its source (PEP 552)


@pytest.fixture
def bare_clone(tmp_path: Path) -> Path:
    """Return a folder, with a blank in its path, that holds what `make env` reads."""
    clone = tmp_path / "a clone"
    for name in ("Makefile", "pyproject.toml", "hatch_build.py", "requirements", "scalar/__init__.py"):
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
    """Without Python 3.11 `make` fails and changes nothing, and one line states what is needed and what was found."""
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
    for stamp in STAMPS:
        (bare_clone / ".venv" / stamp).touch()
    assert make(bare_clone, "--question", "env").returncode == 0


def test_our_modules_are_compiled_and_never_stale(bare_clone: Path) -> None:
    """`make env` compiles the modules that changed since the last call, and what runs is the source, whatever its time says."""
    (bare_clone / ".venv" / "bin").mkdir(parents=True)
    (bare_clone / ".venv" / "bin" / "python").symlink_to(sys.executable)
    for stamp in STAMPS[:-1]:
        (bare_clone / ".venv" / stamp).touch()
    source = bare_clone / "scalar" / "answer.py"
    source.write_text("ANSWER = 1\n", encoding="utf-8")
    assert make(bare_clone, "env").returncode == 0
    bytecode = Path(importlib.util.cache_from_source(str(source)))
    compiled = bytecode.read_bytes()
    assert int.from_bytes(compiled[4:8], "little") == CHECKED_HASH

    times = source.stat()
    source.write_text("ANSWER = 2\n", encoding="utf-8")
    os.utime(source, ns=(times.st_atime_ns, times.st_mtime_ns))  # the same size and time, other content
    run = subprocess.run(
        [
            sys.executable,
            "-B",
            "-c",
            "import sys; sys.path.insert(0, 'scalar'); from answer import ANSWER; print(ANSWER)",
        ],
        cwd=bare_clone,
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.strip() == "2"

    source.touch()
    assert make(bare_clone, "env").returncode == 0
    assert bytecode.read_bytes() != compiled
    assert make(bare_clone, "--question", "env").returncode == 0
