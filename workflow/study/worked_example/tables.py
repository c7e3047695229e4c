"""Tabulate one diagnosis step by step, for the figure and the text of the paper: the residual, the candidates, the effect, the errors.

The diagnosis itself is made by the command line. Here its files are read, and no effect is selected again. The residuals and joint errors of each
pose are computed from the saved calibrations and the dataset.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset, read_dataset
from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.fit.partial_residuals import FittedView
from scalar.diagnosis.fit.scan_residuals import signed_residual
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.picture import Profile
from scalar.estimation.gross_errors import clean
from scalar.estimation.result import Calibration, load_calibration
from scalar.evaluate import Evaluation, evaluate
from scalar.evaluate.truth import read_truth
from scalar.units import DEG, MM, MRAD
from study.blind_trials.score import same

RANKED = 8  # number of candidates in the ranking


def write_control(config: Path, out_dir: Path) -> None:
    """Write the scene of a config without what it injects, as ``scalar simulate`` does: same poses, same draws of noise.

    Raises:
        InvalidInput: The config is at fault.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation import load_config, simulate, write_scene

    write_scene(simulate({**load_config(config), "injected": []}, base_dir=config.parent), out_dir)


def diagnosis_tables(dataset_dir: Path, diagnosis_dir: Path) -> dict[str, pd.DataFrame]:
    """Return the tables of a diagnosis whose first effect is a gear error.

    Args:
        dataset_dir: Folder of the dataset that was diagnosed.
        diagnosis_dir: Folder with before.json, after.json and diagnosis.json.

    Returns:
        ``poses`` has for each pose the joint's angle, the residual before and after, and the error of the joint that the pose shows if only the
        effect is left out of the model (``asked_deg``), and with the whole model (``left_deg``). ``curve`` is the effect over the angle, with its
        standard error. ``ranking`` lists the first candidates of the selection.
    """
    diagnosis = read(diagnosis_dir / "diagnosis.json")
    data = _cleaned(read_dataset(dataset_dir), diagnosis)
    saved = {when: load_calibration(diagnosis_dir / f"{when}.json") for when in ("before", "after")}
    before, after = (_state(data, saved[when]) for when in ("before", "after"))
    effect = after.effects[0]
    assert isinstance(effect, JointHarmonic), effect.name
    view = FittedView.of(after, saved["after"].free, saved["after"].covariance)
    profile = effect.pictures(view)[0]
    assert isinstance(profile, Profile) and profile.curve is not None
    poses = pd.DataFrame(
        {
            "pose": data.pose_ids,
            "plane": [data.planes[k].name for k in data.plane_index],
            "angle_deg": profile.x / DEG,
            "residual_before_mm": signed_residual(before) / MM,
            "residual_after_mm": signed_residual(after) / MM,
            "asked_deg": profile.y / DEG,
            "asked_std_deg": profile.std / DEG,
            "left_deg": profile.rest / DEG,
        }
    )
    names = ("angle_deg", "effect_deg", "effect_std_deg")
    curve = pd.DataFrame(dict(zip(names, profile.curve / DEG, strict=True)))
    return {"poses": poses, "curve": curve, "ranking": _ranking(diagnosis)}


def _cleaned(dataset: Dataset, diagnosis: Mapping[str, Any]) -> Dataset:
    """Return the dataset without what the diagnosis set aside."""
    cleaned = clean(dataset).dataset
    return cleaned.subset(~np.isin(cleaned.pose_ids, diagnosis["outliers"]["poses"]))


def _state(dataset: Dataset, calibration: Calibration) -> FittedState:
    """Return a saved calibration as a fitted state for a dataset; calibrations that needed priors from the data sheet are not supported."""
    assert not calibration.summary["kept_near_data_sheet"]
    model = calibration.model
    geometry = model.names[: model.blocks["effects"].start]
    return refit(dataset, model, np.isin(geometry, calibration.free), model.effects)


def _ranking(diagnosis: Mapping[str, Any]) -> pd.DataFrame:
    """Return the first ``RANKED`` candidates of a diagnosis, and whether each is among the effects found."""
    found = [(effect["name"], effect["target"]) for effect in diagnosis["effects"]]
    rows = [
        {
            "candidate": entry["title"],
            "evidence_nats": entry["evidence_nats"],
            "share_of_residual": entry["share_of_residual"],
            "p_value": entry["p_value"],
            "found": (entry["name"], entry["target"]) in found,
        }
        for entry in diagnosis["candidates"][:RANKED]
    ]
    return pd.DataFrame(rows)


def errors(diagnosis_dir: Path, control: Path, truth: Path, control_truth: Path) -> pd.DataFrame:
    """Return the pose errors before and after the diagnosis and of the matched control, each against the truth of its own scene, base aligned.

    Args:
        diagnosis_dir: Folder with before.json and after.json.
        control: File with the calibration of the scene without the effect.
        truth: Folder with the truth of the scene with the effect.
        control_truth: Folder with the truth of the scene without the effect.

    Returns:
        Columns ``when`` (``before``, ``after``, ``control``), ``poses`` (their number) and those of ``PoseErrors.to_mapping``.
    """
    rows = []
    for when, path, place in (
        ("before", diagnosis_dir / "before.json", truth),
        ("after", diagnosis_dir / "after.json", truth),
        ("control", control, control_truth),
    ):
        calibration = load_calibration(path)
        robot = calibration.model.robot
        found: Evaluation = evaluate(calibration, read_truth(place, robot.n_joints, robot.limits)[0])
        rows.append({"when": when, "poses": len(found.aligned.position)} | found.aligned.to_mapping())
    return pd.DataFrame(rows)


def numbers(
    diagnosis: Mapping[str, Any],
    truth: Mapping[str, Any],
    found: pd.DataFrame,
    tables: Mapping[str, pd.DataFrame],
) -> dict[str, Any]:
    """Return the numbers that the paper quotes; units are in the names, and a nat is the unit of the log evidence.

    Args:
        diagnosis: Content of diagnosis.json.
        truth: Content of truth.json.
        found: As ``errors`` returns it.
        tables: As ``diagnosis_tables`` returns them.
    """
    injected, first = truth["effects"][0], diagnosis["effects"][0]
    sin, cos = (first["coefficients"][f"{name}_rad"]["value"] for name in ("sin", "cos"))
    ranking = tables["ranking"]
    by_when = found.set_index("when").to_dict("index")
    return {
        "injected": {
            "joint": injected["target"]["joint"],
            "order": injected["target"]["order"],
            "amplitude_mrad": injected["size"] / MRAD,
            "poses": len(tables["poses"]),
        },
        "found": {
            "verdict": diagnosis["verdict"],
            "effects": len(diagnosis["effects"]),
            "joint": first["target"]["joint"],
            "order": first["target"]["order"],
            "right": same(first, injected),
            "amplitude_mrad": float(np.hypot(sin, cos)) / MRAD,
            "amplitude_std_mrad": first["coefficients"]["sin_rad"]["std"] / MRAD,
            "p_value": first["p_value"],
        },
        "held_out_rms_mm": {
            "before": diagnosis["residual"]["before"]["held_out_rms_mm"],
            "after": diagnosis["residual"]["after"]["held_out_rms_mm"],
            "noise": diagnosis["residual"]["floor_mm"],
        },
        "errors": {when: {k: v for k, v in row.items() if k != "poses"} for when, row in by_when.items()},
        "errors_over": int(found["poses"].iloc[0]),
        "after_over_control": by_when["after"]["position_mean_mm"] / by_when["control"]["position_mean_mm"],
        "before_over_after": by_when["before"]["position_mean_mm"] / by_when["after"]["position_mean_mm"],
        "best_evidence_nats": float(ranking["evidence_nats"].iloc[0]),
        "lead_nats": float(
            ranking["evidence_nats"].iloc[0] - ranking["evidence_nats"][~ranking["found"]].max()
        ),
    }


def read(path: str | Path) -> Any:
    """Return the content of a JSON file."""
    return json.loads(Path(path).read_text(encoding="utf-8"))
