"""The lock and the marks that a killed Snakemake has left are cleared away; those of a living one are not."""

import base64
import subprocess
import sys
from pathlib import Path

from study.common.take_over import OWNER, clear_incomplete, take_over

OWNS = """
import os, sys
from pathlib import Path
from study.common.take_over import take_over
assert take_over(Path(sys.argv[1]))
locks = Path(sys.argv[1]) / "locks"
locks.mkdir(exist_ok=True)
(locks / "0.output.lock").write_text("results/a")
print("owns", flush=True)
sys.stdin.read()
{}
"""
HOME = Path(__file__).parents[3] / "workflow"


def owner(folder: Path, then: str) -> subprocess.Popen[str]:
    """Start a process that owns a folder, as Snakemake does, and ends in some way when its stdin is closed."""
    process = subprocess.Popen(
        [sys.executable, "-c", OWNS.format(then), folder],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=HOME,
    )
    assert process.stdout is not None and process.stdout.readline() == "owns\n"
    return process


def mark(folder: Path, output: str, longest: int = 100) -> None:
    """Mark an output as incomplete, as Snakemake does."""
    name = base64.urlsafe_b64encode(output.encode()).decode()
    parts = [name[i : i + longest - 1] for i in range(0, len(name), longest - 1)]
    path = folder.joinpath("incomplete", *(f"@{part}" for part in parts[:-1]), parts[-1])
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("{}")


def test_locks_and_marks_stay_while_their_owner_lives(tmp_path: Path) -> None:
    """Locks and marked outputs stay while the owner lives; after its death they are gone, and nothing else is."""
    folder = tmp_path / ".snakemake"
    process = owner(folder, "os.kill(os.getpid(), 9)")
    (tmp_path / "whole").touch()
    (tmp_path / "half").touch()
    mark(folder, "half")
    assert not take_over(folder)
    assert (folder / "locks").exists() and (tmp_path / "half").exists()
    process.communicate("")
    assert take_over(folder)
    assert not (folder / "locks").exists()
    assert {path.name for path in tmp_path.iterdir()} == {".snakemake", "whole"}


def test_locks_of_another_workflow_are_left_alone(tmp_path: Path) -> None:
    """If the last owner was not killed, or there was none, a lock belongs to another workflow and is not removed."""
    folder = tmp_path / ".snakemake"
    owner(folder, "").communicate("")
    assert (folder / OWNER).read_text() == ""
    assert take_over(folder)
    assert (folder / "locks" / "0.output.lock").exists()


def test_the_names_of_marked_outputs_are_read_whatever_their_length(tmp_path: Path) -> None:
    """Marked files and folders are read even if their names are longer than a file name may be, and other files among the marks are left."""
    outputs = ["a", "results/deep/folder", "results/" + "long" * 40]
    for k, output in enumerate(outputs):
        path = tmp_path / output
        path.mkdir(parents=True) if k == 1 else path.parent.mkdir(exist_ok=True, parents=True)
        (path / "half" if k == 1 else path).touch()
        mark(tmp_path, output)
    (tmp_path / "incomplete" / "migration_underway").touch()
    assert sorted(clear_incomplete(tmp_path / "incomplete", tmp_path)) == sorted(outputs)
    assert not any((tmp_path / output).exists() for output in outputs)
    assert [path.name for path in (tmp_path / "incomplete").rglob("*") if path.is_file()] == [
        "migration_underway"
    ]
