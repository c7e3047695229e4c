"""Files that are read and then used: good ones to damage, and functions that calibrate, import, correct, compare and export with them."""

from __future__ import annotations

import functools
import json
import random
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset, read_dataset
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.data.references import References
from scalar.effects.command_line import parse_effects
from scalar.estimation.calibrate import calibrate
from tests.endurance.commands import outcome
from tests.random_scene import Scene, make_scene
from tests.tracked_targets import drawn_arm

N_POSES = 40
LOADS = "payload_deflection,torque_compliance"
"""Effects that use the columns of torques and payloads."""
_DOUBLES = (
    float("nan"), float("inf"), -float("inf"), 0.0, -0.0, 1.0, -1.0, 1e-320, 1e300, -1e300, 1e154, 3e38, 57.3, 1e9,
)  # fmt: skip


@functools.cache
def campaign() -> Dataset:
    """Return a campaign with all that version 2 adds: two targets, whole poses, noises, torques, payloads, commanded joints and nests."""
    rng = np.random.default_rng(11)
    arm = drawn_arm(rng, ("near", "far"), sessions=2)
    q = arm.poses(N_POSES, rng)
    payload = np.where(np.arange(N_POSES) % 2, 3.0, 1.0)
    columns = {
        "order": np.arange(N_POSES, dtype=float),
        "time": 60.0 * np.arange(N_POSES),
        "temperature": 20.0 + 0.1 * np.arange(N_POSES),
        "humidity": rng.uniform(40.0, 60.0, N_POSES),
        "payload": payload,
        **{f"payload_{axis}": 0.01 * payload for axis in "xyz"},
        **{f"approach{j}": np.where(rng.random(N_POSES) < 0.5, -1.0, 1.0) for j in range(1, 7)},
        **{f"qc{j + 1}": q[:, j] + 1e-5 for j in range(6)},
        **{f"tau{j}": rng.normal(0.0, 20.0, N_POSES) for j in range(1, 7)},
    }
    noises = {"noise": 3e-5, "rotation_noise": 1e-4}
    dataset = arm.dataset(
        q,
        rng,
        noise=3e-5,
        turn_noise=1e-4,
        session=(np.arange(N_POSES) >= N_POSES // 2).astype(int),
        columns=columns,
        stated={"noise": 3e-5, "rotation_noise": 1e-4, "point_columns": noises},
    )
    places = rng.uniform(-2.0, 2.0, (3, 3))
    nests = {f"nest_{k}": place + 1e-5 * rng.normal(size=(N_POSES, 3)) for k, place in enumerate(places)}
    return replace(dataset, references=References.of_arrays(nests))


def write_campaign(folder: Path) -> None:
    """Write the campaign, with the tolerance of its robot."""
    campaign().write(folder / "d")
    mapping = load_yaml(folder / "d" / "dataset.yaml")
    mapping["robot"]["tolerance"] = {"length": 1e-3, "angle": 2e-3}
    dump_yaml(mapping, folder / "d" / "dataset.yaml")


def read_campaign(folder: Path) -> Any:
    """Return everything that a folder says, the optional columns as well."""
    data = read_dataset(folder / "d")
    references = data.references
    return (
        data.robot.to_mapping(),
        data.targets,
        data.poses.to_numpy().tolist(),
        {name: values.tolist() for name, values in data.point_columns.items()},
        data.points.tolist(),
        None if references is None else (references.names, references.points.tolist()),
    )


def calibrate_campaign(folder: Path) -> Any:
    """Return the calibrated parameters with the deflections under torque and payload; they are finite."""
    data = read_dataset(folder / "d")
    found = calibrate(data, effects=parse_effects(LOADS, data), explain=False)
    values = found.to_mapping()["parameters"]
    numbers = [entry["value"] for entry in values.values()]
    assert np.isfinite(np.array(numbers, dtype=float)).all(), "a parameter is not finite"
    return {name: round(entry["value"], 6) for name, entry in values.items()}


@functools.cache
def scene() -> Scene:
    """Return scans of three planes, a few of them."""
    return make_scene("vs060", "line-laser", poses_per_plane=2, points_per_scan=60)


def write_recording(folder: Path) -> None:
    """Write a recording of ROS 1, which has no checksums: damage within it reaches the messages."""
    from unittest import mock

    from tests.ingest import bags

    with mock.patch.multiple(bags, RAYS=80, JOINT_RATE=20.0, SCAN_RATE=5.0):
        bags.write_bag(scene().dataset, folder / "campaign.bag", 1, "LaserScan")
    scene().dataset.write(folder / "cell")


def import_recording(folder: Path) -> str:
    """Return what ``scalar import-bag`` says and writes."""
    names = ",".join(f"joint_{i}" for i in range(1, 7))
    out = folder.parent / f"{folder.name}-imported"
    arguments = ["import-bag", folder / "cell", folder / "campaign.bag", "--joint-names", names, "-o", out]
    return outcome(arguments, out).replace(str(folder), "FOLDER")


def with_other_numbers(raw: bytes, rng: random.Random) -> bytes:
    """Return the bytes of a recording in which up to three numbers of messages are others, in doubles, floats or integers."""
    changed = bytearray(raw)
    for _ in range(rng.choice((1, 1, 2, 3))):
        form = rng.choice("ddddfi")
        number: Any = rng.choice(_DOUBLES)
        if form == "i":
            number = rng.choice((0, 1, -1, 2**31 - 1, -(2**31), 1000))
        elif form == "f" and abs(number) > 3.4e38:
            number = float("inf")
        new = struct.pack(f"<{form}", number)
        at = rng.randrange(len(raw) - 8)
        changed[at : at + len(new)] = new
    return bytes(changed)


def write_calibration_to_use(folder: Path) -> None:
    """Write a calibration with effects, another one of the same arm, and a program of joint angles."""
    for rows, name in ((slice(0, 24), "calibration.json"), (slice(12, 36), "later.json")):
        dataset = make_scene("vs060", "tracker", poses_per_plane=12).dataset.subset(np.arange(36)[rows])
        effects = parse_effects("joint_scale:2,joint_harmonic:3:1", dataset)
        calibrate(dataset, effects=effects).save(folder / name)
    rows = [[k, *(0.1 * k + 0.2 * j for j in range(6))] for k in range(3)]
    pd.DataFrame(rows, columns=["pose", *(f"q{j}" for j in range(1, 7))]).to_csv(
        folder / "program.csv", index=False
    )


def use_calibration(folder: Path) -> list[str]:
    """Return what ``correct``, ``compare`` and ``export`` say and write; each may refuse the file, and the first refusal is raised at the end."""
    calibration, out = folder / "calibration.json", folder.parent / f"{folder.name}-out"
    csv, found, table = (out.with_suffix(suffix) for suffix in (".csv", ".json", ".md"))
    said, refusals = [], []
    for arguments, output in (
        (["correct", calibration, folder / "program.csv", "--leave-out", "-o", csv], csv),
        (["compare", calibration, folder / "later.json", "-o", found], found),
        (["export", calibration, "-o", table], table),
    ):
        try:
            said.append(outcome(arguments, output).replace(str(folder), "FOLDER"))
        except Exception as error:
            refusals.append(error)
    for error in sorted(refusals, key=lambda error: not isinstance(error, AssertionError)):
        raise error
    return said


def write_truth_to_use(folder: Path) -> None:
    """Write a calibration and the truth of its scene."""
    scene = make_scene("vs060", "line-laser", poses_per_plane=8, points_per_scan=10)
    calibrate(scene.dataset).save(folder / "calibration.json")
    scene.write_truth(folder / "truth", np.random.default_rng(0))
    poses = pd.read_csv(folder / "truth" / "truth_poses.csv")
    poses.head(20).to_csv(folder / "truth" / "truth_poses.csv", index=False)


def evaluate_by_truth(folder: Path) -> str:
    """Return what ``scalar evaluate`` says and writes."""
    out = folder.parent / f"{folder.name}-evaluated"
    arguments = ["evaluate", folder / "calibration.json", folder / "truth", "-o", out]
    return outcome(arguments, out).replace(str(folder), "FOLDER")


@functools.cache
def _whole_diagnosis() -> str:
    from scalar.diagnosis import diagnose

    return json.dumps(diagnose(_diagnosed(), outer_folds=0).to_mapping(), indent=1)


@functools.cache
def _diagnosed() -> Dataset:
    return make_scene("vs060", "tracker", poses_per_plane=16).dataset


def write_whole_diagnosis(folder: Path) -> None:
    """Write a diagnosis as the command writes it, with all of its keys, and two effects that it could not tell apart."""
    content = json.loads(_whole_diagnosis())
    entry = {
        "name": "joint_scale",
        "target": {"joint": 2},
        "coefficients": {"scale_rad_per_rad": {"value": 1e-4, "std": 1e-5}},
    }
    entry |= {
        "p_value": 1e-9,
        "confidence": 0.5,
        "selected_in": None,
        "confounded_with": [{"name": "joint_compliance", "target": {"joints": [2]}}],
    }
    content["effects"].append(entry)
    (folder / "diagnosis.json").write_text(json.dumps(content, indent=1))


def read_whole_diagnosis(folder: Path) -> Any:
    """Return the questions that ``plan --after`` finds."""
    from scalar.cli.plan_after import read_questions

    pairs, beyond = read_questions(folder / "diagnosis.json", (), _diagnosed())
    return [pair.title for pair in pairs], beyond


def write_batch_result(folder: Path) -> None:
    """Write the result of one dataset of a batch."""
    from scalar.cli.fleet import RESULT, content_of_result

    _diagnosed().write(folder / "d")
    (folder / "out").mkdir()
    content = content_of_result(_job(folder), _row())
    (folder / "out" / RESULT).write_text(json.dumps(content, indent=1))


def read_batch_result(folder: Path) -> Any:
    """Return the line of the table that a batch that goes on takes over, which is the one that was written; None: the dataset is diagnosed again."""
    from scalar.cli.fleet import finished_row

    row = finished_row(_job(folder))
    assert row is None or row == _row(), "a damaged line was taken"
    return row


def _row() -> dict[str, Any]:
    """Return a line of the table of a batch."""
    from scalar.report.fleet_row import COLUMNS

    words = {"verdict": "effect", "robot": "arm", "effects": "x", "message": ""}
    return {**dict.fromkeys(COLUMNS[1:], 0.5), "status": 0, **words}


def _job(folder: Path) -> Any:
    from scalar.cli.fleet import Job

    return Job("d", folder / "d", folder / "out", 0, ())
