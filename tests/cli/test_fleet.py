"""``scalar diagnose --batch``: one table, in one order; a bad folder harms no other; stopped anywhere, it goes on to the same bytes."""

from __future__ import annotations

import errno
import hashlib
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import pytest

from scalar.cli.fleet import Job
from scalar.data.io import temporary
from scalar.diagnosis.held_out.repeated_runs import available_cores
from tests.cli.fleets import run, table
from tests.random_scene import make_scene

ERRORS = (("data_sheet", ""), ("after", ""), ("after", "_at_most"))
"""What the table says of the workspace: the arm as described is wrong by millimetres, as calibrated by what the band allows."""


def contents(folder: Path) -> dict[str, str]:
    """Return the checksum of every file below a folder."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


@pytest.mark.slow
def test_a_bad_folder_harms_no_other(fleet: Path, instantly: list[str], tmp_path: Path) -> None:
    """Each dataset has its line, in the order of names: sound ones are diagnosed, the others say what is wrong, and the exit status is theirs."""
    result = run("diagnose", "--batch", fleet, "-o", tmp_path / "out", "--quick")
    assert result.exit_code == 2, result.output
    rows = table(tmp_path / "out")
    names = [f"robot-{k}/campaign" for k in range(5)]
    assert list(rows) == names
    assert [rows[name]["status"] for name in names] == ["2", "0", "0", "0", "2"]
    assert "poses.csv" in rows[names[0]]["message"] and rows[names[0]]["held_out_after_mm"] == ""
    for name in names[1:4]:
        files = {path.name for path in (tmp_path / "out" / name).iterdir()}
        assert files == {"before.json", "after.json", "diagnosis.json", "report.html", "batch.json"}
        assert float(rows[name]["held_out_after_mm"]) > 0 and rows[name]["robot"] == "vs060"
        errors = [float(rows[name][f"{key}_error{end}_mm"]) for key, end in ERRORS]
        assert errors[0] > errors[2] > errors[1] > 0
    said = [line.split(":")[0] for line in result.stdout.splitlines()]
    assert said[:5] == names


@pytest.mark.parametrize(("fate", "words"), [("killed", "by signal 9"), ("broken", "RuntimeError")])
def test_a_process_that_ends_takes_no_other_with_it(
    fate: str, words: str, fleet: Path, instantly: list[str], tmp_path: Path
) -> None:
    """A diagnosis that ends its process, or raises what nobody foresaw, has status 70 in its line; it is tried again by the next call."""
    instantly.append(fate)
    result = run("diagnose", "--batch", fleet / "robot-1", fleet / "robot-0", "-o", tmp_path, "--quick")
    rows = table(tmp_path)
    assert result.exit_code == 2 and [row["status"] for row in rows.values()] == ["2", "70"]
    assert words in rows["robot-1/campaign"]["message"]
    instantly.clear()
    run("diagnose", "--batch", fleet / "robot-1", fleet / "robot-0", "-o", tmp_path, "--quick")
    assert [row["status"] for row in table(tmp_path).values()] == ["2", "0"]


def test_a_full_disk_is_no_answer_about_a_dataset(
    fleet: Path, instantly: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a report does not fit on the disk and a smaller file does, the line says so, the older result stays, and the next call tries again."""
    call = ("diagnose", "--batch", fleet / "robot-1", "-o", tmp_path)
    assert run(*call).exit_code == 0
    older = contents(tmp_path / "campaign")
    write = Path.write_bytes

    def full(path: Path, content: bytes) -> int:
        if "report.html" in path.name:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(path, content)

    with monkeypatch.context() as meanwhile:
        meanwhile.setattr(Path, "write_bytes", full)
        assert run(*call, "--quick").exit_code == 70
    (row,) = table(tmp_path).values()
    assert row["status"] == "70" and "disk space ran out" in row["message"]
    assert contents(tmp_path / "campaign") == older
    assert run(*call, "--quick").exit_code == 0


def test_what_is_finished_stays_and_what_has_changed_is_done_again(
    fleet: Path, instantly: list[str], tmp_path: Path
) -> None:
    """A second call computes nothing and writes the same table; after a change of a file or an option, that result is made anew."""
    one, two = fleet / "robot-1", tmp_path / "copy"
    make_scene(kind="tracker", seed=2, poses_per_plane=9).write(two / "campaign")
    call = ("diagnose", "--batch", one, two, "-o", tmp_path / "out")
    assert run(*call, "--quick").exit_code == 0
    first = contents(tmp_path / "out")
    instantly.append("broken")  # whatever is computed from now on is refused
    assert run(*call, "--quick").exit_code == 0
    assert contents(tmp_path / "out") == first
    with open(two / "campaign" / "dataset.yaml", "a", encoding="utf-8") as file:
        file.write("# changed\n")
    assert run(*call, "--quick").exit_code == 70
    changed, same = (table(tmp_path / "out")[f"{name}/campaign"]["status"] for name in ("copy", "robot-1"))
    assert (changed, same) == ("70", "0")
    assert run(*call).exit_code == 70
    assert [row["status"] for row in table(tmp_path / "out").values()] == ["70", "70"]


@pytest.mark.slow
def test_killed_and_called_again_it_gives_the_same_bytes(fleet: Path, tmp_path: Path) -> None:
    """If the run is killed as soon as one result is there, its workers end and that result is kept.

    The second call ends with the bytes of an undisturbed run.
    """
    call = [sys.executable, "-m", "scalar.cli", "diagnose", "--batch", str(fleet), "--quick", "-o"]
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    assert subprocess.run([*call, whole], capture_output=True).returncode == 2
    running = subprocess.Popen([*call, stopped], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    kept = stopped / "robot-1" / "campaign" / "batch.json"
    while not kept.exists() and running.poll() is None:
        time.sleep(0.02)
    running.kill()
    running.wait()
    assert kept.exists()
    made_at = kept.stat().st_mtime_ns
    again = subprocess.run([*call, stopped], capture_output=True, text=True)
    assert again.returncode == 2, again.stderr
    assert kept.stat().st_mtime_ns == made_at
    assert contents(stopped) == contents(whole)


@pytest.mark.slow
def test_the_hidden_folder_of_a_worker_that_outlived_its_run_is_removed(
    fleet: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, instantly: list[str]
) -> None:
    """If a worker of a killed run still lives when the next run begins, its hidden folder is removed when that run ends."""
    here, at_first = os.getpid(), iter([True])
    monkeypatch.setattr(temporary, "lives", lambda pid: os.getpid() != here or next(at_first, False))
    left = temporary.temporary_beside(tmp_path / "out" / "robot-2" / "campaign")
    left.mkdir(parents=True)
    run("diagnose", "--batch", fleet, "-o", tmp_path / "out")
    assert next(at_first, None) is None and not left.exists()


@pytest.mark.parametrize(("options", "cores"), [([], available_cores()), (["--cores", "1"], 1)])
def test_the_number_of_processes_may_be_given(
    options: list[str], cores: int, fleet: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A machine that others use as well is not filled; without the option, as many processes run as there are processors."""
    asked: list[int] = []

    def nothing_done(jobs: Sequence[Job], cores: int, done: object) -> list[dict[str, object]]:
        asked.append(cores)
        return []

    monkeypatch.setattr("scalar.cli.fleet_table.run_all", nothing_done)
    run("diagnose", "--batch", fleet, "--quick", *options, "-o", tmp_path / "out")
    assert asked == [cores]


def test_one_dataset_at_a_time_without_the_option(fleet: Path, tmp_path: Path) -> None:
    """Two datasets without --batch are refused in one sentence that names the option."""
    result = run("diagnose", fleet / "robot-1", fleet / "robot-2", "-o", tmp_path / "out")
    assert result.exit_code == 2 and "--batch" in result.stderr and not (tmp_path / "out").exists()
