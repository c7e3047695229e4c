"""Compare models of a measured robot by their errors on held-out blocks of poses.

The truth is not known here, so models are compared by how well they predict poses to which they were not fitted. Three models are compared with that
of the diagnosis: one in which only the poses of base (tracker, planes) and sensor are fitted; one in which the geometry of the arm is fitted as
well; and one with the geometry fitted and the effects of another campaign, fixed as they were found there. Two checks test the diagnosis: another
split of the poses, with fits of its own; and a control in which the effects of joints are computed from the angles of other poses, so that they
cannot explain anything.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.poses import is_joint
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.measured_rows import MeasuredRows
from scalar.diagnosis.held_out.hold_out import held_out_errors
from scalar.diagnosis.held_out.repetitions import first_of_repetitions
from scalar.diagnosis.naming.finding import UNATTRIBUTED
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.effect import Effect
from scalar.effects.places import JointEffect
from scalar.estimation.data_sheet_priors import fit_near_data_sheet
from scalar.estimation.gross_errors import clean
from scalar.estimation.joint_fit import unobservable_coefficients
from scalar.estimation.least_squares import fit
from scalar.estimation.model import Model
from scalar.estimation.prepare import Prepared, prepare
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration
from scalar.geometry.se3 import Array
from scalar.sensors import measure
from scalar.units import MM
from study.blind_trials.score import SURE
from study.common.provenance import code_version

SUMMARY_COLUMNS = ("set", "model", "poses", "train_rms_mm", "held_out_rms_mm", "held_out_max_mm")
FRESH_SHARE = 0.3  # share of the different poses that are drawn at random and held out in the other split, each with its repetitions
_SEED = 20260  # seed of the other split and of the shuffled angles
FEW_COEFFICIENTS = 3  # most coefficients of an effect with which the summary lists them
SHUFFLED = "effects_on_shuffled_angles"
BASE_AND_TOOL, BEFORE, AFTER = "base_and_tool", "geometry", "geometry_and_effects"
"""Names of the models in the tables."""


def compare(dataset: Dataset) -> dict[str, dict[str, float]]:
    """Return the errors of two models: with only base and sensor fitted, and with the geometry fitted as well.

    The values are ``{poses, train_rms_mm, held_out_rms_mm, held_out_max_mm}``, errors in mm.
    """
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
    """Return the errors with the geometry fitted and the effects fixed as another campaign found them; values as those of ``compare``."""
    cleaned, prepared = _prepared(dataset)
    return _errors(_refitted(cleaned, prepared.initial.model, prepared.free, effects))


def on_a_fresh_split(dataset: Dataset, found: Calibration) -> dict[str, float]:
    """Return the RMS errors [mm] on poses of another split, held out from whole fits: of the geometry alone, and with the effects found.

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
    """Return the errors with effects of joints that are fitted to the angles of other poses, so that they cannot explain anything.

    The values are those of ``compare``.

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
    dataset: Dataset, prepared: Prepared, effects: Sequence[Effect], found: Calibration, effect_poses: Dataset
) -> FittedState:
    """Return the optimum of geometry and effects for a dataset, started without effects.

    Args:
        dataset: The dataset without gross errors.
        prepared: The preparation of the whole dataset for a fit.
        effects: The effects to fit.
        found: A calibration with effects. Rows are weighted by its residual, as the priors of the effects' sizes assume.
        effect_poses: Has the poses from which the effects are computed: those of ``dataset``, or shuffled ones.
    """
    nothing = tuple(effect.with_coefficients(np.zeros(len(effect.coefficients))) for effect in effects)
    model = replace(prepared.coarse, effects=nothing).rebased()
    left = float(found.residual_rms / np.sqrt(measure(dataset).rows_per_pose))
    stated = replace(dataset, sensor=replace(dataset.sensor, noise=left))
    whole = Residuals.of(dataset, model, measure(stated))
    of_effects = Residuals.of(effect_poses, model, whole.measurement)
    residuals = Residuals(whole.measurement, whole.poses, of_effects.bases, whole.known)
    free = np.r_[prepared.free, np.ones(sum(len(e.coefficients) for e in effects), dtype=bool)]
    free &= ~unobservable_coefficients(residuals, model, free) if effects else True
    return _near_data_sheet(dataset, residuals, fit(residuals, model, free).model, prepared.free, free)


def _refitted(dataset: Dataset, model: Model, free: Array, effects: Sequence[Effect]) -> FittedState:
    """Return the optimum of a model's free parameters ``free``, with the effects fixed."""
    model = replace(model, effects=tuple(effects)).rebased()
    all_free = np.r_[free, np.zeros(sum(len(effect.coefficients) for effect in effects), dtype=bool)]
    residuals = Residuals.of(dataset, model).reweighted(model)
    found = fit(residuals, model, all_free)
    model = found.model.rebased()
    residuals = residuals.reweighted(model)
    return _near_data_sheet(dataset, residuals, fit(residuals, model, all_free).model, free, all_free)


def _near_data_sheet(
    dataset: Dataset, residuals: Residuals, model: Model, geometry_free: Array, free: Array
) -> FittedState:
    """Return the optimum with the priors of the data sheet, as a calibration has them, from the optimum ``model`` without them.

    Without them, the fit to a part of the poses may have geometry that these poses do not determine, and which predicts the others wrongly.
    """
    model = fit_near_data_sheet(residuals, model, free, DEFAULTS.estimation, near_optimum=True)
    return FittedState(dataset, model, geometry_free, free, residuals, DEFAULTS, MeasuredRows(dataset))


def _errors(state: FittedState) -> dict[str, float]:
    """Return the number of poses, and the errors [mm] of a fitted model on the poses of the fit and on held-out ones."""
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
    floors: Mapping[str, Mapping[str, Any] | None],
) -> tuple[dict[str, Any], pd.DataFrame, pd.DataFrame]:
    """Return the summary of all sets, the same errors as a table with a row for each set and model, and the errors of all gears.

    Args:
        files: ``{set: {original file: SHA-256}}``.
        diagnoses: ``{set: content of diagnosis.json}``.
        errors: ``{set: {model: errors}}``, as ``compare`` and ``transferred`` return them.
        checks: ``{set: {"fresh_split": .., "shuffled": ..}}``, as ``on_a_fresh_split`` and ``on_shuffled_angles`` return them.
        gears: ``{set: table}``, as ``study.measured.gears.gear_errors`` returns it, with the column ``set``.
        agreements: ``{pair of sets: list}``, as ``study.measured.gears.agreement`` returns it.
        floors: ``{set: what repeated poses show}``, as ``study.measured.repeated.floor_of`` returns it.
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
            "unseen": _unseen(diagnosis["residual"]),
            "sure": sum(
                effect["confidence"] >= SURE and effect["name"] != UNATTRIBUTED
                for effect in diagnosis["effects"]
            ),
            "effects": [_summarised(effect) for effect in diagnosis["effects"]],
            "outlier_poses": diagnosis["outliers"]["poses"],
            "floor_mm": diagnosis["residual"]["floor_mm"],
            "repeated_poses": floors[name],
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


def _unseen(residual: Mapping[str, Any]) -> dict[str, Any]:
    """Return the errors [mm] before and after on poses that took no part in cleaning, selection or fit, each with its spread over their parts."""
    return {
        f"{when}_{what}": residual[when][f"unseen_{what}"]
        for when in ("before", "after")
        for what in ("rms_mm", "rms_spread_mm")
    }


def _summarised(effect: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a summary keeps of an effect in diagnosis.json; its coefficients only if there are at most ``FEW_COEFFICIENTS``."""
    kept = {
        key: effect.get(key)
        for key in (
            "name",
            "target",
            "p_value",
            "held_out_rms_before_mm",
            "held_out_rms_after_mm",
            "confidence",
            "selected_in",
        )
    }
    kept["also_possible"] = len(effect["confounded_with"])
    return kept | (
        {"coefficients": effect["coefficients"]} if len(effect["coefficients"]) <= FEW_COEFFICIENTS else {}
    )
