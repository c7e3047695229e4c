"""What a measured set says of its robot, from the bare model upwards, always on blocks of poses held out.

Truth is not known here: the one judge is how well poses are predicted that no fit has seen. Three models are
compared with the diagnosis: only the places of base (tracker, planes) and sensor fitted; the geometry as well;
and the geometry with another campaign's effects, fixed as they were found there. Two checks guard what the diagnosis says: another split of the
poses, with fits of its own, and a control in which effects must explain nothing: effects on joints that are given the angles of
other poses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.poses import is_joint
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.hold_out import first_of_repetitions, held_out_errors
from scalar.diagnosis.measured_rows import MeasuredRows
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.effect import Effect
from scalar.effects.places import JointEffect
from scalar.estimation.gross_errors import clean
from scalar.estimation.joint_fit import unobservable_coefficients
from scalar.estimation.least_squares import fit
from scalar.estimation.prepare import Prepared, prepare
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration
from scalar.geometry.se3 import Array
from scalar.sensors import measure
from scalar.units import MM
from study.common.provenance import code_version

SUMMARY_COLUMNS = ("set", "model", "poses", "train_rms_mm", "held_out_rms_mm", "held_out_max_mm")
FRESH_SHARE = 0.3  # of the poses, drawn at random, each with its repetitions
_SEED = 20260
FEW_COEFFICIENTS = 3
SHUFFLED = "effects_on_shuffled_angles"
BASE_AND_TOOL, BEFORE, AFTER = "base_and_tool", "geometry", "geometry_and_effects"


def compare(dataset: Dataset) -> dict[str, dict[str, float]]:
    """Return the errors [mm] with only base and sensor fitted, and with the geometry as well."""
    cleaned, prepared = _prepared(dataset)
    model = prepared.initial.model
    fixed = set(model.robot.parameter_names)
    if not prepared.residuals.measurement.observes_orientation:
        fixed |= {"sensor_rx", "sensor_ry", "sensor_rz"}
    placed = np.array([name not in fixed for name in model.names])
    return {
        BASE_AND_TOOL: _errors(_refitted(cleaned, model, placed, ())),
        BEFORE: _errors(_refitted(cleaned, model, prepared.free, ())),
    }


def _prepared(dataset: Dataset) -> tuple[Dataset, Prepared]:
    """Return a dataset without gross errors, and its preparation for a fit."""
    cleaned = clean(dataset).dataset
    return cleaned, prepare(cleaned)


def transferred(dataset: Dataset, effects: Sequence[Effect]) -> dict[str, float]:
    """Return the errors [mm] with the geometry fitted and the effects fixed as another campaign found them."""
    cleaned, prepared = _prepared(dataset)
    return _errors(_refitted(cleaned, prepared.initial.model, prepared.free, effects))


def on_a_fresh_split(dataset: Dataset, found: Calibration) -> dict[str, float]:
    """Return the errors [mm] on poses drawn anew and held out from whole fits, of the geometry alone and with the effects found.

    Args:
        dataset: The dataset that was diagnosed.
        found: The calibration with effects.
    """
    cleaned, prepared = _prepared(dataset)
    first = first_of_repetitions(cleaned.q)
    unlike = np.unique(first)
    out = np.isin(first, np.random.default_rng(_SEED).permutation(unlike)[: round(FRESH_SHARE * len(unlike))])
    rest, drawn = cleaned.subset(~out), cleaned.subset(out)
    errors: dict[str, float] = {"poses": drawn.n_poses}
    for name, effects in (("before", ()), ("after", found.model.effects)):
        model = _fitted(rest, prepared, effects, found, rest).model
        errors[f"{name}_rms_mm"] = Residuals.of(drawn, model).rms(model) / MM
    return errors


def on_shuffled_angles(dataset: Dataset, found: Calibration) -> dict[str, float]:
    """Return the errors [mm] with effects that are fitted anew to the angles of other poses: nothing is left for them to explain.

    Args:
        dataset: The dataset that was diagnosed.
        found: The calibration with effects.
    """
    cleaned, prepared = _prepared(dataset)
    order = np.random.default_rng(_SEED).permutation(cleaned.n_poses)
    angles = [name for name in cleaned.poses if is_joint(name)]
    others = cleaned.poses.assign(**{name: cleaned.poses[name].to_numpy()[order] for name in angles})
    effects = tuple(e for e in found.model.effects if isinstance(e, JointEffect))
    return _errors(_fitted(cleaned, prepared, effects, found, replace(cleaned, poses=others)))


def _fitted(
    dataset: Dataset, prepared: Prepared, effects: Sequence[Effect], found: Calibration, seen: Dataset
) -> FittedState:
    """Return the optimum of geometry and effects, started without effects; the effects are computed from the poses of ``seen``.

    Rows are weighted by the residual that the calibration left, as the priors of the effects' sizes assume.
    """
    nothing = tuple(effect.with_coefficients(np.zeros(len(effect.coefficients))) for effect in effects)
    model = replace(prepared.coarse, effects=nothing).rebased()
    left = float(found.residual_rms / np.sqrt(measure(dataset).rows_per_pose))
    stated = replace(dataset, sensor=replace(dataset.sensor, noise=left))
    whole = Residuals.of(dataset, model, measure(stated))
    told = Residuals.of(seen, model, whole.measurement)
    residuals = Residuals(whole.measurement, whole.poses, told.bases, whole.known)
    free = np.r_[prepared.free, np.ones(sum(len(e.coefficients) for e in effects), dtype=bool)]
    free &= ~unobservable_coefficients(residuals, model, free) if effects else True
    return FittedState(
        dataset,
        fit(residuals, model, free).model,
        prepared.free,
        free,
        residuals,
        DEFAULTS,
        MeasuredRows(dataset),
    )


def _refitted(dataset: Dataset, model: Any, free: Array, effects: Sequence[Effect]) -> FittedState:
    """Return the optimum of a model whose effects are fixed."""
    model = replace(model, effects=tuple(effects)).rebased()
    all_free = np.r_[free, np.zeros(sum(len(effect.coefficients) for effect in effects), dtype=bool)]
    residuals = Residuals.of(dataset, model).reweighted(model)
    found = fit(residuals, model, all_free)
    model = found.model.rebased()
    residuals = residuals.reweighted(model)
    return FittedState(
        dataset,
        fit(residuals, model, all_free).model,
        free,
        all_free,
        residuals,
        DEFAULTS,
        MeasuredRows(dataset),
    )


def _errors(state: FittedState) -> dict[str, float]:
    error = held_out_errors(state)
    return {
        "poses": state.dataset.n_poses,
        "train_rms_mm": state.residuals.rms(state.model) / MM,
        "held_out_rms_mm": error.rms / MM,
        "held_out_max_mm": error.largest / MM,
    }


def summarise(
    files: Mapping[str, Mapping[str, str]],
    diagnoses: Mapping[str, Mapping[str, Any]],
    errors: Mapping[str, Mapping[str, Mapping[str, float]]],
    checks: Mapping[str, Mapping[str, Any]],
    gears: Mapping[str, pd.DataFrame],
    agreements: Mapping[str, Sequence[Mapping[str, Any]]],
) -> tuple[dict[str, Any], pd.DataFrame, pd.DataFrame]:
    """Return the summary of all sets, the same errors as a table with a row for each set and model, and the errors of all gears.

    Args:
        files: by set, the SHA-256 of each original file.
        diagnoses: by set, the content of ``diagnosis.json``.
        errors: by set and model, the errors [mm] of `compare` and `transferred`.
        checks: by set, ``fresh_split`` and ``shuffled``.
        gears: by set, what `study.measured.gears.gear_errors` gives.
        agreements: by pair of sets, what `study.measured.gears.agreement` gives.
    """
    sets: dict[str, Any] = {}
    rows = []
    for name, diagnosis in diagnoses.items():
        after = {"poses": errors[name][BEFORE]["poses"], **diagnosis["residual"]["after"]}
        models = {**errors[name], AFTER: after}
        sets[name] = {
            "files_sha256": dict(files[name]),
            "verdict": diagnosis["verdict"],
            "models": models,
            "effects": [_told(effect) for effect in diagnosis["effects"]],
            "outlier_poses": diagnosis["outliers"]["poses"],
            "floor_mm": diagnosis["residual"]["floor_mm"],
            "checks": dict(checks[name]),
        }
        rows += [{"set": name, "model": model, **values} for model, values in models.items()]
        rows.append({"set": name, "model": SHUFFLED, **checks[name]["shuffled"]})
    table = pd.DataFrame(rows).reindex(columns=list(SUMMARY_COLUMNS))
    summary = {
        "format": "scalar-measured/1",
        "code": code_version(),
        "held_out": "blocks of successive poses, repetitions of a pose with its first time",
        "sets": sets,
        "agreement": {
            pair: {f"joint_{row['joint']}": dict(row) for row in found} for pair, found in agreements.items()
        },
    }
    return summary, table, pd.concat(list(gears.values()), ignore_index=True)


def _told(effect: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a summary keeps of an effect: its coefficients only where they are few enough to be read."""
    kept = {
        key: effect.get(key)
        for key in ("name", "target", "p_value", "held_out_rms_before_mm", "held_out_rms_after_mm")
    }
    kept["also_possible"] = len(effect["confounded_with"])
    return kept | (
        {"coefficients": effect["coefficients"]} if len(effect["coefficients"]) <= FEW_COEFFICIENTS else {}
    )
