"""Everything that reads a file, each with good files to damage and a function that reads them and says what it made of them."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import read_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.io.json_reader import read_json
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import load_calibration
from tests.random_scene import make_scene
from tests.robot_descriptions import random_description
from tests.small_datasets import description, tables

CONFIGS = Path(__file__).parents[2] / "configs"


@dataclass(frozen=True)
class Reader:
    """One thing that reads files.

    Attributes:
        name: What it reads.
        make: Writes good files to an empty folder.
        read: Reads the files of a folder, and returns plain data or text that say what was made of them.
        damaged: Patterns of the files to damage.
        content: Returns the plain data of a file as the reader is meant to see it; files whose content is that of the good ones
            have to be read alike. None where there is no simple one.
    """

    name: str
    make: Callable[[Path], None]
    read: Callable[[Path], Any]
    damaged: tuple[str, ...] = ("*",)
    content: Callable[[Path], Any] | None = None


def answer(value: Any) -> str:
    """Return a checksum of an answer."""
    return hashlib.sha256(repr(value).encode(errors="surrogatepass")).hexdigest()


def _dataset(kind: str, table_format: str = "csv") -> Callable[[Path], None]:
    return lambda folder: write_dataset(
        folder / "d", mapping=description(kind), table_format=table_format, **tables(kind)
    )


def _read_dataset(folder: Path) -> Any:
    data = read_dataset(folder / "d")
    return data.robot, data.planes, data.q.tolist(), data.points.tolist()


def _make_calibration(folder: Path) -> None:
    scene = make_scene("panda", "tracker", poses_per_plane=12)
    calibrate(scene.dataset).save(folder / "calibration.json")


def _read_calibration(folder: Path) -> Any:
    calibration = load_calibration(folder / "calibration.json")
    n = calibration.model.robot.n_joints
    q = np.random.default_rng(1).uniform(-1, 1, (3, n))
    columns = {"order": np.arange(3.0), "time": np.arange(3.0), "temperature": np.full(3, 20.0)}
    frames = calibration.predict(q, **columns)
    assert np.isfinite(frames).all(), "a calibration was read, and predicts what is not finite"
    return frames.tolist()


def _make_diagnosis(folder: Path) -> None:
    """Write a diagnosis as the format has it, with the parts that readers look at."""
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


def _read_diagnosis(folder: Path) -> Any:
    from scalar.cli.plan_after import read_questions

    dataset = _tracked()
    pairs, beyond = read_questions(folder / "diagnosis.json", (), dataset)
    return [pair.title for pair in pairs], beyond


_TRACKED: list[Any] = []


def _tracked() -> Any:
    if not _TRACKED:
        _TRACKED.append(make_scene("panda", "tracker", poses_per_plane=12).dataset)
    return _TRACKED[0]


def _make_scene(folder: Path) -> None:
    scene = load_yaml(CONFIGS / "scenes" / "injected.yaml")
    shutil.copy(CONFIGS / "scenes" / scene["robot"], folder / "robot.yaml")
    dump_yaml(scene | {"robot": "robot.yaml"}, folder / "scene.yaml")


def _read_scene(folder: Path) -> Any:
    from scalar.simulation import load_config

    return load_config(folder / "scene.yaml")


def _make_study(folder: Path) -> None:
    for name in ("blind_trials_smoke.yaml", "blind_trials_stratified_smoke.yaml", "smoke.yaml"):
        shutil.copy(CONFIGS / name, folder)
    for name in ("smoke.csv", "smoke_noise.csv", "plane_tilt.csv"):
        shutil.copy(CONFIGS / "grids" / name, folder)


def _read_study(folder: Path) -> Any:
    """Read every config; a refusal of one leaves the others to be read."""
    from study.blind_trials.cases import load_study
    from study.blind_trials.stratified import load_design
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


def _make_mapping(folder: Path) -> None:
    both = tables("tracker")
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {
            "files": [{"name": "table.csv"}],
            "columns": {
                **{f"q{i}": {"column": f"q{i}", "unit": "deg", "sign": -1} for i in range(1, 7)},
                **{c: {"column": c, "unit": "mm"} for c in "xyz"},
            },
        },
        "dataset": description("tracker"),
    }
    dump_yaml(mapping, folder / "mapping.yaml")
    both["poses"].merge(both["points"]).to_csv(folder / "table.csv", index=False)


def _read_mapping(folder: Path) -> Any:
    from scalar.ingest.convert import import_dataset

    target = folder.with_name(folder.name + "-imported")
    try:
        import_dataset(folder / "mapping.yaml", [folder / "table.csv"], target)
        return {path.name: path.read_text() for path in sorted(target.iterdir())}
    finally:
        shutil.rmtree(target, ignore_errors=True)


def _make_urdf(folder: Path) -> None:
    (folder / "arm.urdf").write_text(random_description(np.random.default_rng(3), 5))


def _read_urdf(folder: Path) -> Any:
    from scalar.ingest.urdf import robot_from_urdf

    robot, T = robot_from_urdf(folder / "arm.urdf", tip="tip")
    return robot.to_mapping(), T.tolist()


def _make_joints(folder: Path) -> None:
    _make_calibration(folder)
    rows = ["pose,q1,q2,q3,q4,q5,q6,q7", *(f"{k}" + ",0.1" * 7 for k in range(4))]
    (folder / "joints.csv").write_text("\n".join(rows) + "\n")


def _read_joints(folder: Path) -> Any:
    """Predict by the command line, where an unexpected exception becomes exit status 70; the calibration has no fault, and is read once."""
    out = folder.with_name("frames.csv")
    out.unlink(missing_ok=True)
    given = [str(folder / "calibration.json"), str(folder / "joints.csv"), "-o", str(out)]
    calibration = _sound_calibration((folder / "calibration.json").read_bytes(), folder / "calibration.json")
    with mock.patch("scalar.estimation.result.load_calibration", lambda path: calibration):
        result = CliRunner().invoke(cli, ["predict", *given])
    if result.exit_code == 2:
        assert not out.exists() and result.stderr.startswith("scalar: "), result.output
        raise InvalidInput([])
    assert result.exit_code == 0, result.output
    return out.read_text()


_CALIBRATIONS: dict[bytes, Any] = {}


def _sound_calibration(raw: bytes, path: Path) -> Any:
    if raw not in _CALIBRATIONS:
        _CALIBRATIONS[raw] = load_calibration(path)
    return _CALIBRATIONS[raw]


def _make_dh(folder: Path) -> None:
    rows = [
        "a_m,alpha_rad,d_m,theta_rad,lower_rad,upper_rad",
        *(f"0.1,{k % 2},0.2,0.0,-2.5,2.5" for k in range(1, 7)),
    ]
    (folder / "dh.csv").write_text("\n".join(rows) + "\n")


def _read_dh(folder: Path) -> Any:
    from scalar.ingest.dh_table import robot_from_dh_table

    return robot_from_dh_table(folder / "dh.csv", "modified-dh", "arm")


def _make_truth(folder: Path) -> None:
    scene = make_scene("panda", "tracker", poses_per_plane=4)
    scene.write_truth(folder / "truth", np.random.default_rng(0))


def _read_truth(folder: Path) -> Any:
    from scalar.evaluate.truth import read_truth

    poses, content = read_truth(folder / "truth", 7)
    return poses.to_numpy().tolist(), content


def _make_bag(folder: Path) -> None:
    from tests.ingest.bags import write_bag

    scene = make_scene("vs060", "line-laser", poses_per_plane=1, points_per_scan=20)
    write_bag(scene.dataset, folder / "campaign.bag", 1, "LaserScan")


def _read_bag(folder: Path) -> Any:
    from scalar.ingest.bag.messages import read_bag

    recording = read_bag(folder / "campaign.bag")
    return recording.positions.tolist(), len(recording.scans)


def _json(path: Path) -> Any:
    return read_json(path)


def _yaml(path: Path) -> Any:
    return load_yaml(path)


READERS = {
    reader.name: reader
    for reader in (
        Reader("dataset of scans", _dataset("line-laser"), _read_dataset),
        Reader("dataset of a probe", _dataset("probe"), _read_dataset),
        Reader("dataset of a tracker", _dataset("tracker"), _read_dataset),
        Reader("dataset in Parquet", _dataset("line-laser", "parquet"), _read_dataset, ("*.parquet",)),
        Reader("calibration", _make_calibration, _read_calibration, content=_json),
        Reader("diagnosis", _make_diagnosis, _read_diagnosis, content=_json),
        Reader("scene", _make_scene, _read_scene, content=_yaml),
        Reader("config and grids", _make_study, _read_study),
        Reader("mapping and table", _make_mapping, _read_mapping),
        Reader("URDF", _make_urdf, _read_urdf),
        Reader("DH table", _make_dh, _read_dh),
        Reader("joints, by the command", _make_joints, _read_joints, ("joints.csv",)),
        Reader("truth", _make_truth, _read_truth),
        Reader("bag", _make_bag, _read_bag),
    )
}
