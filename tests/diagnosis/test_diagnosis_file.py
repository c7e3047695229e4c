"""The files that ``scalar diagnose`` writes: the documented format, the same bytes each time, and calibrations that can be used."""

import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import read_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.diagnosis import diagnose
from scalar.estimation.result import load_calibration
from scalar.report.output import write_diagnosis
from tests.diagnosis.cases import bow, compliance, drift, harmonic, jitter, knock
from tests.diagnosis.gross_errors import spoiled
from tests.diagnosis.unnamed_causes import unnamed
from tests.effects.injected import make_cell

SCHEMA = json.loads((Path(__file__).parent / "diagnosis.schema.json").read_text(encoding="utf-8"))
FILES = ("after.json", "before.json", "diagnosis.json", "report.html")


def written(cell, folder, dataset=None, *, order=None, table_format="csv"):
    """Write a workcell as a dataset folder, its rows in any order, and return the folder."""
    data = cell.dataset if dataset is None else dataset
    ids = np.repeat(data.pose_ids, np.diff(data.starts))
    scans = pd.DataFrame({"pose": ids, "x": data.points[:, 0], "z": data.points[:, 1]})
    poses = data.poses
    if order is not None:
        poses = poses.iloc[order].reset_index(drop=True)
    write_dataset(folder, mapping=cell.scene.mapping(), poses=poses, scans=scans, table_format=table_format)
    return folder


def run(folder, out):
    return CliRunner().invoke(
        cli, ["diagnose", str(folder), "-o", str(out), "--quick"], catch_exceptions=False
    )


def strict(path):
    """Return the content of a JSON file; a number that is not finite is an error."""
    return json.loads(
        path.read_text(encoding="utf-8"), parse_constant=lambda word: pytest.fail(f"{word} in {path}")
    )


CASES = {
    "clean": lambda: make_cell(seed=1, poses_per_plane=40),
    "compliance": lambda: compliance(2)[0],
    "harmonic": lambda: harmonic(3)[0],
    "drift": lambda: drift(4)[0],
    "bow": lambda: bow(5)[0],
    "knock": lambda: knock(6)[0],
    "jitter": lambda: jitter(7)[0],
    "unnamed": lambda: unnamed(8)[0],
}


SLOW = ("jitter", "unnamed")


@pytest.mark.parametrize(
    "label", [pytest.param(label, marks=pytest.mark.slow) if label in SLOW else label for label in CASES]
)
def test_every_verdict_follows_the_format(label):
    """For every verdict, diagnosis.json has the documented names and targets, and its numbers are finite or null."""
    mapping = diagnose(CASES[label]().dataset).to_mapping()
    jsonschema.validate(mapping, SCHEMA)
    names = [effect["name"] for effect in mapping["effects"]]
    assert (mapping["verdict"] == "unattributed") == (bool(names) and names[-1] == "unattributed")
    assert "unattributed" not in names[:-1]
    assert_finite(mapping)


def assert_finite(value):
    if isinstance(value, dict):
        for part in value.values():
            assert_finite(part)
    elif isinstance(value, list):
        for part in value:
            assert_finite(part)
    elif isinstance(value, float):
        assert math.isfinite(value)


@pytest.mark.slow
def test_the_same_dataset_gives_the_same_bytes(tmp_path):
    """Two runs on one folder write the same four files, byte for byte, and nothing else; a copy in parquet gives the same."""
    cell, *_ = harmonic(11, poses_per_plane=40)
    folder = written(cell, tmp_path / "cell")
    outs = [tmp_path / name for name in ("one", "two")]
    for out in outs:
        result = run(folder, out)
        assert result.exit_code == 0, result.output
    assert sorted(p.name for p in outs[0].iterdir()) == sorted(FILES)
    for name in FILES:
        assert (outs[0] / name).read_bytes() == (outs[1] / name).read_bytes(), name
    again = written(cell, tmp_path / "parquet", table_format="parquet")
    assert run(again, tmp_path / "three").exit_code == 0
    assert (
        strict(tmp_path / "three" / "diagnosis.json")["effects"]
        == strict(outs[0] / "diagnosis.json")["effects"]
    )


@pytest.mark.slow
def test_the_order_of_rows_does_not_matter(tmp_path):
    """If ``order`` is stated, rows in any order give the same diagnosis.json."""
    cell, *_ = knock(12, poses_per_plane=40)
    dataset = spoiled(cell.dataset, np.random.default_rng(1), points=0.01)[0]
    poses = dataset.poses.assign(order=np.arange(dataset.n_poses))
    from dataclasses import replace

    dataset = replace(dataset, poses=poses)
    straight = written(cell, tmp_path / "straight", dataset)
    shuffled = np.random.default_rng(2).permutation(dataset.n_poses)
    mixed = written(cell, tmp_path / "mixed", dataset, order=shuffled)
    for folder in (straight, mixed):
        assert run(folder, tmp_path / f"{folder.name}-out").exit_code == 0
    one, two = (tmp_path / f"{n}-out" / "diagnosis.json" for n in ("straight", "mixed"))
    assert one.read_bytes() == two.read_bytes()


def test_the_calibrations_can_be_used(tmp_path):
    """before.json and after.json can be loaded and predict. They differ by the effect, and the coefficient in diagnosis.json is the one that
    after.json applies, in radians.
    """
    cell, _, target = harmonic(13, poses_per_plane=40)
    folder = written(cell, tmp_path / "cell")
    assert run(folder, tmp_path / "out").exit_code == 0
    before, after = (load_calibration(tmp_path / "out" / f"{n}.json") for n in ("before", "after"))
    assert not before.model.effects and len(after.model.effects) == 1
    found = strict(tmp_path / "out" / "diagnosis.json")["effects"][0]
    applied = dict(
        zip(after.model.effects[0].coefficient_names, after.model.effects[0].coefficients, strict=True)
    )
    for name, entry in found["coefficients"].items():
        # Forward selection fits the rows of tests, the calibration all points: the same to a hundredth of the error bar.
        assert abs(entry["value"] - applied[name]) < 0.01 * entry["std"]
    size = np.hypot(*(v["value"] for v in found["coefficients"].values()))
    spread = max(v["std"] for v in found["coefficients"].values())
    assert abs(size - 3e-4) < 5 * spread < 3e-4
    assert found["target"] == target
    T = after.predict(read_dataset(folder).poses)
    assert np.isfinite(T).all() and np.abs(T - before.predict(read_dataset(folder).poses)).max() > 1e-5
    for name in ("before.json", "after.json"):
        assert_finite(strict(tmp_path / "out" / name))


def test_numbers_are_in_the_units_of_their_names():
    """Noise of 0.2 mm within and 0.3 mm between scans is stated as such, in millimetres; the errors before and after and the noise floor have the
    right order.
    """
    from tests.effects.injected import Flaws

    cell = make_cell(Flaws(bias=3e-4), seed=14, noise=2e-4, stated_noise=None, points_per_scan=40)
    mapping = diagnose(cell.dataset).to_mapping()
    assert mapping["noise"]["within_scan_mm"] == pytest.approx(0.2, rel=0.05)
    assert mapping["effects"][0]["name"] == "scan_bias"
    assert mapping["effects"][0]["coefficients"]["std_m"]["value"] == pytest.approx(3e-4, rel=0.2)
    assert mapping["noise"]["between_scans_mm"] == pytest.approx(
        0.3 * 0.85, rel=0.3
    )  # across a slanted target plane
    residual = mapping["residual"]
    # A fit that weighs poses by their noise has a larger plain residual than the one that minimises it.
    assert (
        residual["floor_mm"] < residual["after"]["train_rms_mm"] < 1.05 * residual["before"]["train_rms_mm"]
    )
    assert residual["before"]["train_rms_mm"] < residual["before"]["held_out_rms_mm"]
    assert residual["before"]["held_out_rms_mm"] < residual["before"]["held_out_max_mm"]


def test_nothing_is_left_of_a_diagnosis_that_fails(tmp_path, monkeypatch):
    """If the report cannot be made, nothing is written at all."""
    import scalar.report

    diagnosis = diagnose(make_cell(seed=15, poses_per_plane=30).dataset)
    monkeypatch.setattr(scalar.report, "render_report", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write_diagnosis(diagnosis, tmp_path)
    assert not list(tmp_path.iterdir())
