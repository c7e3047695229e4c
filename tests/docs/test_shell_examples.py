"""The commands that README and documentation show: each exists, with the options shown; those of the first page are run."""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from snakemake.cli import get_argument_parser

import scalar.cli  # noqa: F401 - registers the commands
from scalar.cli.group import cli

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "config/README.md",
    *sorted((ROOT / "docs").glob("*.md")),
]
NOT_OURS = {".", "cp", "echo", "git", "pip", "printf", "pytest", "podman", "python"}
RUN = "<!-- run -->\n"


def blocks(page: Path, before: str = "") -> list[str]:
    """Return the shell blocks of a page, or those after a mark."""
    text = page.read_text(encoding="utf-8")
    return re.findall(rf"{re.escape(before)}```sh\n(.*?)```", text, re.DOTALL)


def inline(page: Path) -> Iterator[str]:
    """Return the commands of ours that stand in a sentence."""
    prose = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for code in re.findall(r"`([^`]+)`", prose):
        if re.match(r"(scalar|snakemake|make) \S", code := " ".join(code.split())):
            yield code


def commands(page: Path) -> list[list[str]]:
    """Return the words of every command on a page; comments and what stands behind `|` or `>` are left out."""
    lines = [line for block in blocks(page) for line in block.replace("\\\n", " ").splitlines()]
    split = [shlex.split(line.split(" > ")[0].split(" >> ")[0], comments=True) for line in lines]
    for line in inline(page):
        for part in line.split(" && "):
            split.append(shlex.split(part))
    return [words for words in split if words]


def check_scalar(words: list[str]) -> None:
    """Parse a command of ours as the command line would, without running it or looking for its files."""
    if not words or words == ["COMMAND"]:
        return
    if words[0].startswith("-"):
        assert words[0] in ("--help", "--version"), words
        return
    command = cli.get_command(click.Context(cli), words[0])
    assert command is not None, f"no command {words[0]}"
    if "--help" not in words and len(words) > 1:
        context = click.Context(command, info_name=words[0])
        command.make_parser(context).parse_args(list(words[1:]))


def check_snakemake(words: list[str]) -> None:
    """Parse a command of Snakemake as it would; each target is a rule, or a file below results."""
    parser = get_argument_parser()
    parser.error = lambda message: pytest.fail(message)
    targets = parser.parse_args(words).targets
    text = "".join(path.read_text("utf-8") for path in (ROOT / "workflow").rglob("*.smk"))
    for target in targets:
        known = re.search(rf"(?m)^(use )?rule .*\b{re.escape(target)}\b", text)
        assert known or target.startswith("results/"), f"no rule {target}"


def check_make(words: list[str]) -> None:
    """Check that each target stands in the Makefile."""
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for word in words:
        assert "=" in word or re.search(rf"(?m)^{re.escape(word)}:", makefile), f"no target {word}"


CHECKS = {"scalar": check_scalar, "snakemake": check_snakemake, "make": check_make}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_shows_exists(page: Path):
    """Every command of a page, in a block or in a sentence, is known with its options and targets."""
    for words in commands(page):
        if words[0] in CHECKS:
            try:
                CHECKS[words[0]](words[1:])
            except (AssertionError, click.UsageError) as error:
                pytest.fail(f"{page.name}: {' '.join(words)}: {error}")
        else:
            assert words[0] in NOT_OURS, f"{page.name}: {' '.join(words)}"


@pytest.mark.parametrize(
    "words", [["calibrte", "x"], ["calibrate", "x", "--outptu", "y"], ["correct", "--units"]]
)
def test_a_wrong_command_is_found(words: list[str]):
    """The check of the pages can fail: it finds a misspelt command or option, and an option without its value."""
    with pytest.raises((AssertionError, click.UsageError)):
        check_scalar(words)


@pytest.mark.slow
def test_the_first_calibration_runs(tmp_path: Path):
    """The blocks of the first page that are marked so run one after the other, and leave the files that the page names."""
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    page = ROOT / "docs/first_calibration.md"
    script = "set -e\n" + "\n".join(blocks(page, RUN))
    assert script.count("scalar ") >= 6
    search = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    ran = subprocess.run(
        ["bash", "-c", script],
        cwd=tmp_path,
        env={**os.environ, "PATH": search},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    for name in ("sim/dataset", "out/calibration.json", "frames.csv", "corrected.csv", "calibrated.md"):
        assert (tmp_path / name).exists(), name
