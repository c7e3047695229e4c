"""Faults in the files of a dataset, and options that name nothing, are refused with file, row and column."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.cli.running import INPUT_AT_FAULT, JOINTS, refused, run
from tests.small_datasets import edit_cell, edit_lines


def drop_scan(folder: Path) -> None:
    """Take all points of pose 7 away."""
    edit_lines(folder, "scans.csv", lambda lines: [line for line in lines if not line.startswith("7,")])


def scale_column(folder: Path, file: str, columns: list[str], factor: float) -> None:
    """Multiply columns of a table."""
    table = pd.read_csv(folder / file)
    table[columns] = table[columns] * factor
    table.to_csv(folder / file, index=False)


def replace_text(folder: Path, file: str, old: str, new: str) -> None:
    """Replace the first occurrence of a text."""
    text = (folder / file).read_text(encoding="utf-8")
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")


@pytest.mark.parametrize(("spoil", "words"), [
    (drop_scan, ["poses.csv, row 8, column pose", "pose 7 has no laser point"]),
    (lambda f: edit_cell(f, "poses.csv", 5, "q3", "abc"), ["poses.csv, row 5, column q3", "not a number"]),
    (lambda f: edit_cell(f, "poses.csv", 5, "q3", "nan"), ["poses.csv, row 5, column q3"]),
    (lambda f: edit_cell(f, "poses.csv", 5, "q3", ""), ["poses.csv, row 5, column q3"]),
    (lambda f: edit_cell(f, "scans.csv", 9, "z", "inf"), ["scans.csv, row 9, column z"]),
    (lambda f: edit_cell(f, "poses.csv", 4, "pose", "2"), ["poses.csv, row 4, column pose", "row 3"]),
    (lambda f: edit_cell(f, "scans.csv", 4, "pose", "999"), ["scans.csv, row 4", "unknown pose 999"]),
    (lambda f: edit_cell(f, "poses.csv", 3, "plane", "flor"), ["row 3, column plane", "flor", "floor"]),
    (lambda f: edit_cell(f, "poses.csv", 1, "q2", "joint2"), ["poses.csv", "q2"]),
    (lambda f: scale_column(f, "poses.csv", JOINTS, 180 / np.pi), ["poses.csv", "degrees"]),
    (lambda f: scale_column(f, "scans.csv", ["x", "z"], 1e3), ["scans.csv", "millimetres"]),
    (lambda f: replace_text(f, "dataset.yaml", "name:", "nam:"), ["dataset.yaml", "nam"]),
    (lambda f: replace_text(f, "dataset.yaml", "name:", "x: !!python/none\nname:"), ["dataset.yaml"]),
    (lambda f: (f / "scans.csv").unlink(), ["scans"]),
    (lambda f: (f / "dataset.yaml").unlink(), ["dataset.yaml"]),
    (shutil.rmtree, ["dataset"]),
])  # fmt: skip
def test_faults_in_the_files_are_refused(spoil, words, dataset, tmp_path):
    """``validate`` and ``calibrate`` name file, row and column on stderr, end with exit status 2, and leave no output folder."""
    spoil(dataset)
    for command in (["validate", dataset], ["calibrate", dataset, "-o", tmp_path / "out"]):
        refused(run(*command), INPUT_AT_FAULT, *words, output=tmp_path / "out")


def test_an_old_result_survives_a_failed_run(sound, dataset, tmp_path):
    """A refused calibration leaves an earlier calibration.json as it was."""
    out = Path(shutil.copytree(sound / "out", tmp_path / "out"))
    drop_scan(dataset)
    refused(run("calibrate", dataset, "-o", out), INPUT_AT_FAULT)
    assert [path.name for path in out.iterdir()] == ["calibration.json"]
    assert (out / "calibration.json").read_bytes() == (sound / "out/calibration.json").read_bytes()


@pytest.mark.parametrize(("options", "words"), [
    (["--hold", "a_9"], ["--hold", "a_9"]),
    (["--effects", "no_such_effect"], ["--effects", "no_such_effect"]),
    (["--effects-from", "missing.json"], ["missing.json"]),
])  # fmt: skip
def test_options_that_name_nothing_are_refused(options, words, sound, tmp_path):
    """Unknown parameters, effects and files give exit status 2, and the message contains the name."""
    result = run("calibrate", sound / "dataset", "-o", tmp_path / "out", *options)
    refused(result, INPUT_AT_FAULT, *words, output=tmp_path / "out")
