"""The last guard: whatever nobody foresaw is one line and exit status 70, an interruption is quiet, and names do no harm."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import scalar.data.folder
from scalar.cli import cli
from scalar.data.dataset_writer import write_dataset
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from tests.small_datasets import description, tables


def raising(error: BaseException, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let whatever reads a folder raise an error."""

    def read(path: Path) -> None:
        raise error

    monkeypatch.setattr(scalar.data.folder, "read_folder", read)


@pytest.mark.parametrize(
    "error", [KeyError("x"), IndexError("a\nb"), MemoryError(), RecursionError("too deep"), AssertionError()]
)
def test_an_unexpected_error_is_one_line_with_the_command_to_report_it(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Any error of any kind gives exit status 70 and one line that quotes the command, and no traceback."""
    raising(error, monkeypatch)
    result = CliRunner().invoke(cli, ["validate", "my cell"])
    assert result.exit_code == 70
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith("scalar: ") and type(error).__name__ in line
    assert line.endswith("SCALAR_TRACEBACK=1 scalar validate 'my cell'")


def test_the_traceback_is_shown_where_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the variable is set in the environment, the traceback comes first; --help names the variable."""
    raising(KeyError("x"), monkeypatch)
    monkeypatch.setenv("SCALAR_TRACEBACK", "1")
    result = CliRunner().invoke(cli, ["validate", "cell"])
    assert result.exit_code == 70
    assert result.stderr.startswith("Traceback")
    assert "in read" in result.stderr
    assert "SCALAR_TRACEBACK=1" in CliRunner().invoke(cli, ["--help"]).stdout


def test_an_interruption_is_quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C ends with exit status 130, as in shells, and prints nothing."""
    raising(KeyboardInterrupt(), monkeypatch)
    result = CliRunner().invoke(cli, ["validate", "cell"])
    assert (result.exit_code, result.stdout, result.stderr) == (130, "", "")


def test_a_name_outside_the_terminals_encoding_is_written_as_escapes(tmp_path: Path) -> None:
    """On a terminal with Western European encoding, characters that it lacks become escapes, and the command succeeds."""
    mapping = {**description("tracker"), "name": "Zelle-\u00fc-\u4e2d"}
    write_dataset(tmp_path / "d", mapping=mapping, **tables("tracker"))
    done = subprocess.run(
        [sys.executable, "-m", "scalar.cli", "validate", str(tmp_path / "d")],
        env={**os.environ, "PYTHONIOENCODING": "latin-1:strict"},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(b"Zelle-\xfc-\\u4e2d: robot")


def test_a_name_does_not_steer_the_terminal(tmp_path: Path) -> None:
    """Characters that reverse the direction of text, and escape codes, are written as escapes."""
    mapping = {**description("tracker"), "name": "a\u202eb\x1b[2J"}
    write_dataset(tmp_path / "d", mapping=mapping, **tables("tracker"))
    result = CliRunner().invoke(cli, ["validate", str(tmp_path / "d")])
    assert result.exit_code == 0, result.output
    assert r"a\u202eb\x1b[2J" in result.stdout


@pytest.mark.parametrize("name", [".", "", "/"])
def test_import_and_predict_refuse_an_output_without_a_name(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``-o .``, ``-o ''`` and ``-o /`` name no folder and no file, so the exit status is 2 and nothing is written."""
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {
            "columns": {
                **{f"q{i}": {"column": f"q{i}", "unit": "rad"} for i in range(1, 7)},
                **{c: {"column": c, "unit": "m"} for c in "xyz"},
            }
        },
        "dataset": description("tracker"),
    }
    both = tables("tracker")
    (tmp_path / "in").mkdir()
    dump_yaml(mapping, tmp_path / "in" / "mapping.yaml")
    both["poses"].merge(both["points"]).to_csv(tmp_path / "in" / "table.csv", index=False)
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path / "out")
    result = CliRunner().invoke(cli, ["import", "../in/mapping.yaml", "../in/table.csv", "-o", name])
    assert result.exit_code == 2, result.output
    assert any(said in result.stderr for said in ("no name for an output", "already there", "an empty path"))
    assert not list((tmp_path / "out").iterdir())
    assert load_yaml(tmp_path / "in" / "mapping.yaml") == mapping


@pytest.mark.parametrize("arguments", [["--help"], ["predict", "--help"], ["init", "--help"], ["--version"]])
def test_a_closed_pipe_ends_quietly(arguments: list[str]) -> None:
    """If the reader of a pipe has gone, there is no traceback and no message, and the status is that of a command that SIGPIPE ends."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "scalar.cli", *arguments]
    ended = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert (ended.returncode, ended.stderr) == (141, "")


@pytest.mark.parametrize(
    ("arguments", "status"),
    [(["validate", "no-such-folder"], 2), (["validate"], 2), (["no-such-command"], 2), (["--help"], 141)],
)
def test_the_exit_status_says_what_is_wrong_also_if_nobody_reads_the_messages(
    arguments: list[str], status: int
) -> None:
    """If the one reader of stdout and stderr has gone, as in ``2>&1 | true``, a refusal keeps its status; other output has that of a closed pipe."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "scalar.cli", *arguments]
    ended = subprocess.run(command, stdout=writer, stderr=writer, check=False)
    os.close(writer)
    assert ended.returncode == status
