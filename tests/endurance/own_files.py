"""Files in formats of ``scalar``: good ones to damage, and functions that read them and return what was read."""

from __future__ import annotations

import functools
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from scalar.data.dataset import Dataset, read_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import load_calibration
from tests.endurance.commands import outcome
from tests.random_scene import make_scene
from tests.small_datasets import description, tables

CONFIGS = Path(__file__).parents[2] / "configs"


def dataset_writer(kind: str, table_format: str = "csv") -> Callable[[Path], None]:
    """Return a function that writes a dataset of a kind of sensor to the folder ``d`` within a folder."""
    return lambda folder: write_dataset(
        folder / "d", mapping=description(kind), table_format=table_format, **tables(kind)
    )


def read_dataset_folder(folder: Path) -> Any:
    data = read_dataset(folder / "d")
    return data.robot, data.planes, data.q.tolist(), data.points.tolist()


def write_calibration_file(folder: Path) -> None:
    scene = make_scene("panda", "tracker", poses_per_plane=12)
    calibrate(scene.dataset).save(folder / "calibration.json")


def read_calibration_file(folder: Path) -> Any:
    calibration = load_calibration(folder / "calibration.json")
    n = calibration.model.robot.n_joints
    q = np.random.default_rng(1).uniform(-1, 1, (3, n))
    columns = {"order": np.arange(3.0), "time": np.arange(3.0), "temperature": np.full(3, 20.0)}
    frames = calibration.predict(q, **columns)
    assert np.isfinite(frames).all(), "a calibration was read, and predicts what is not finite"
    return frames.tolist()


def write_diagnosis_file(folder: Path) -> None:
    """Write a diagnosis.json with the parts of the format that its readers use."""
    entry = {
        "name": "joint_harmonic",
        "target": {"joint": 2, "order": 1},
        "coefficients": {"sin_rad": {"value": 1e-4, "std": 2e-6}, "cos_rad": {"value": 1e-4, "std": 2e-6}},
        "p_value": 1e-12,
        "held_out_rms_before_mm": 0.3,
        "held_out_rms_after_mm": 0.1,
        "confounded_with": [{"name": "joint_scale", "target": {"joint": 2}}],
        "confidence": 0.9,
        "selected_in": 1.0,
    }
    content = {
        "format": "scalar-diagnosis/2",
        "verdict": "effect",
        "effects": [entry],
        "unobservable": [
            {"name": "joint_scale", "target": {"joint": 1}, "observability": 1e-9, "consequence": "x"}
        ],
        "outliers": {"poses": [1], "points": 0, "mislabelled": []},
    }
    (folder / "diagnosis.json").write_text(json.dumps(content, indent=1))


def read_diagnosis_file(folder: Path) -> Any:
    from scalar.cli.plan_after import read_questions

    pairs, beyond = read_questions(folder / "diagnosis.json", (), _tracked())
    return [pair.title for pair in pairs], beyond


@functools.cache
def _tracked() -> Dataset:
    return make_scene("panda", "tracker", poses_per_plane=12).dataset


def write_joints_file(folder: Path) -> None:
    write_calibration_file(folder)
    rows = ["pose,q1,q2,q3,q4,q5,q6,q7", *(f"{k}" + ",0.1" * 7 for k in range(4))]
    (folder / "joints.csv").write_text("\n".join(rows) + "\n")


def read_joints_file(folder: Path) -> Any:
    """Return what ``scalar predict`` says and writes; raise what it refuses. The calibration is never damaged, and is read only once."""
    out = folder.with_name("frames.csv")
    calibration = _sound_calibration((folder / "calibration.json").read_bytes(), folder / "calibration.json")
    with mock.patch("scalar.estimation.result.load_calibration", lambda path: calibration):
        return outcome(["predict", folder / "calibration.json", folder / "joints.csv", "-o", out], out)


_CALIBRATIONS: dict[bytes, Any] = {}


def _sound_calibration(raw: bytes, path: Path) -> Any:
    if raw not in _CALIBRATIONS:
        _CALIBRATIONS[raw] = load_calibration(path)
    return _CALIBRATIONS[raw]


def write_truth_folder(folder: Path) -> None:
    scene = make_scene("panda", "tracker", poses_per_plane=4)
    scene.write_truth(folder / "truth", np.random.default_rng(0))


def read_truth_folder(folder: Path) -> Any:
    from scalar.evaluate.truth import read_truth

    poses, content = read_truth(folder / "truth", 7)
    return poses.to_numpy().tolist(), content


def write_scene_files(folder: Path) -> None:
    scene = load_yaml(CONFIGS / "scenes" / "injected.yaml")
    shutil.copy(CONFIGS / "scenes" / scene["robot"], folder / "robot.yaml")
    dump_yaml(scene | {"robot": "robot.yaml"}, folder / "scene.yaml")


def read_scene_files(folder: Path) -> Any:
    from scalar.simulation import load_config

    return load_config(folder / "scene.yaml")


def write_config_files(folder: Path) -> None:
    for name in ("blind_trials_smoke.yaml", "blind_trials_stratified_smoke.yaml", "smoke.yaml"):
        shutil.copy(CONFIGS / name, folder)
    for name in ("smoke.csv", "smoke_noise.csv", "plane_tilt.csv"):
        shutil.copy(CONFIGS / "grids" / name, folder)


def read_config_files(folder: Path) -> Any:
    """Read every config and grid, also after one was refused; raise the first refusal if there is one."""
    from study.blind_trials.cases import load_study
    from study.blind_trials.stratified_design import load_design
    from study.common.grid import read_grid
    from study.common.schema_faults import schema_faults
    from study.common.yaml_numbers import with_numbers

    def config() -> Any:
        content = with_numbers(load_yaml(folder / "smoke.yaml"))
        faults = schema_faults(content, CONFIGS.parent / "workflow/schemas/config.schema.json")
        return faults or content

    reads: list[Callable[[], Any]] = [
        config,
        lambda: list(load_study(folder / "blind_trials_smoke.yaml").jobs()),
        lambda: list(load_design(folder / "blind_trials_stratified_smoke.yaml").jobs()),
        *(lambda path=path: read_grid(path) for path in sorted(folder.glob("*.csv"))),
    ]
    answers, refusals = [], []
    for read in reads:
        try:
            answers.append(read())
        except InvalidInput as error:
            refusals.append(error)
    if refusals:
        raise refusals[0]
    return answers
