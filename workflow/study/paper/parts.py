"""Numbers of the paper that no study writes: the setup, the settings of the method, the statements of the original paper, and ratios."""

from __future__ import annotations

from collections.abc import Mapping
from math import asin, exp, hypot, log
from pathlib import Path
from typing import Any

import pandas as pd

from scalar.baseline import fit as baseline
from scalar.baseline.parameterisation import DH_KINDS, SENSOR
from scalar.diagnosis.naming import jitter_at_neighbours, many_orders
from scalar.diagnosis.naming.most_confidence import NEARLY_SURE, NOT_SURE, ONE_OF_TWO
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.flexible.unattributed import Unattributed
from scalar.effects.joint_harmonic import MAX_ORDER, MAX_RIPPLE_ORDER
from scalar.effects.registry import known
from scalar.geometry import parallel_axes
from scalar.units import DEG, MM, MRAD
from study.blind_trials.score import SURE
from study.blind_trials.statistics import LEVEL
from study.blind_trials.stratified_score import MUCH_WORSE, WORSE
from study.common.methods import INITIAL, PROPOSED
from study.common.scene_config import is_wall
from study.common.statistics import BAND, QUANTITIES
from study.confidence.fit import MEDIUM_POSES
from study.paper.measured import measured_counts
from study.published_curves.curves import LEFT_OUT
from study.sweeps.numbers import NEAR_BOUND
from study.sweeps.summary import LOST_MM

EQUATIONS_PER_POSE = 2
"""A scan of a plane is a straight line: an offset and a slope, however many points it has."""
CLIPPED = "baseline-clip"
"""The variant of the baseline with which the proposed method is compared: it changes the square root only where that is undefined."""
FEW_POSES = 60
"""Largest number of poses of the sets in the row ``60 poses`` of the stratified trials."""
SIZE_UNITS = {
    "mrad": ("°", MRAD / DEG),
    "factor": ("σ", 1.0),
    "share": ("σ", 1.0),
    "relative": ("tolerance", 1.0),
    "count": ("iterations", 1.0),
}
"""``{unit of a magnitude in the results: (unit in the paper, factor to it)}``; σ is the stated noise."""
VARIANCE_COMPONENTS = 2
"""Number of effects that are variance components: a jitter of the poses, and an error common to a scan."""


def setup(scene: Path, tilted: Path, seeds: int) -> dict[str, Any]:
    """Return the headline's setup: counts, and sizes with their unit in the name.

    Args:
        scene: Config file of the main study's scene.
        tilted: Config file of the same scene with leaning walls.
        seeds: Number of seeds.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.config import load_config, poses_wanted

    config = load_config(scene)
    leaning = [plane["normal"] for plane in load_config(tilted)["planes"] if is_wall(plane)]
    wall = next(plane for plane in config["planes"] if is_wall(plane))
    joints, planes = len(config["robot"]["joints"]), len(config["planes"])
    poses = sum(poses_wanted(config))
    points = config["sensor"]["points_per_scan"]
    near, far = config["sensor"]["range_m"]
    printed = len(DH_KINDS) * joints + len(SENSOR) + 4 * planes
    constrained = 1 + planes  # unit vectors: the scanner's axis, and the normals
    return {
        "seeds": seeds,
        "joints": joints,
        "planes": planes,
        "poses": poses,
        "poses_per_plane": poses // planes,
        "points": points,
        "points_in_all": poses * points,
        "equations_per_pose": EQUATIONS_PER_POSE,
        "equations": EQUATIONS_PER_POSE * poses,
        "parameters_dh": len(DH_KINDS) * joints,
        "parameters_sensor": len(SENSOR),
        "parameters_planes": 4 * planes,
        "parameters_printed": printed,
        "parameters_constrained": constrained,
        "parameters_independent": printed - constrained,
        "noise_mm": config["noise"]["range_noise_std_m"] / MM,
        "fan_half_angle_deg": config["sensor"]["fan_half_angle_deg"],
        "range_near_mm": near / MM,
        "range_far_mm": far / MM,
        "incidence_deg": config["sensor"]["incidence_max_deg"],
        "wall_distance_m": wall["distance_m"],
        "walls_lean_deg": max(asin(abs(n[2]) / hypot(*n)) for n in leaning) / DEG,
        "plane_offset_mm": config["plane_guess"]["offset_m"] / MM,
        "plane_tilt_deg": config["plane_guess"]["tilt_deg"],
        "length_error_mm": config["initial_model"]["length_std_m"] / MM,
        "angle_error_deg": config["initial_model"]["angle_std_deg"],
        "evaluation_poses": config["truth_poses"],
    }


def settings() -> dict[str, Any]:
    """Return the settings of the method, from the code."""
    return {
        "null_tolerance": DEFAULTS.estimation.identifiability.null_tolerance,
        "near_parallel_rad": parallel_axes.NEAR_PARALLEL,
        "max_evaluations": baseline.MAX_EVALUATIONS,
        "band_low": BAND[0],
        "band_high": BAND[1],
        "effects": len(known()) - (Unattributed.name in known()) + VARIANCE_COMPONENTS,
        "highest_order": MAX_ORDER,
        "highest_ripple": MAX_RIPPLE_ORDER,
        "alpha": DEFAULTS.selection.alpha_named_effect,
        "least_improvement": DEFAULTS.selection.least_improvement,
        "swap_margin": DEFAULTS.selection.swap_margin,
        "confounded_margin": DEFAULTS.selection.confounded_margin,
        "variance_component_alpha": DEFAULTS.selection.alpha_unnamed,
        "unattributed_alpha": DEFAULTS.selection.alpha_unnamed,
        "least_confidence": DEFAULTS.naming.least_confidence,
        "most_confidence_jitter": NOT_SURE,
        "correlation_length_of_scatter": jitter_at_neighbours.CORRELATION_LENGTH,
        "most_confidence_of_two": ONE_OF_TWO,
        "most_confidence_nearly_sure": NEARLY_SURE,
        "poses_per_order": many_orders.POSES_PER_ORDER,
        "worth_correcting": DEFAULTS.shipped_fit.worth_correcting,
        "most_extrapolated": DEFAULTS.shipped_fit.most_extrapolated,
        "folds": DEFAULTS.hold_out.folds,
        "most_poses_of_sets": DEFAULTS.subset_search.most_poses,
        "overwhelming_evidence": DEFAULTS.selection.overwhelming_evidence,
        "blocks": DEFAULTS.hold_out.folds * DEFAULTS.hold_out.blocks_per_fold,
        "point_sigmas": DEFAULTS.estimation.gross_errors.point_sigmas,
        "pose_sigmas": DEFAULTS.estimation.gross_errors.pose_sigmas,
        "least_pose_error_mm": DEFAULTS.estimation.gross_errors.least_pose_error / MM,
    }


def conventions() -> dict[str, Any]:
    """Return the numbers that belong to no result: levels of intervals, widths of bands."""
    return {
        "interval": LEVEL,
        "standard_errors": 2,
        "band_low": BAND[0],
        "band_high": BAND[1],
        "near_bound": NEAR_BOUND,
        "sure": SURE,
        "worse": WORSE - 1,
        "much_worse": MUCH_WORSE - 1,
        "few_poses": FEW_POSES,
        "medium_poses": MEDIUM_POSES,
        "lost_mm": LOST_MM,
    }


def stated(
    headline: pd.DataFrame,
    planes: pd.DataFrame,
    curves: pd.DataFrame,
    claims: pd.DataFrame,
    judged: pd.DataFrame,
) -> dict[str, Any]:
    """Return what the original paper states, with the columns ``QUANTITIES`` at keys such as ``headline.initial`` and ``curves.noise.0.01``.

    ``headline`` and ``curves`` are its plot data; ``text`` has the rounded numbers of its text, as printed.

    Args:
        headline: published_headline.csv.
        planes: published_plane_errors.csv.
        curves: published_curves.csv.
        claims: published_claims.csv.
        judged: judged_claims.csv.
    """
    columns = list(QUANTITIES)
    states: Any = headline.set_index("state")[columns]
    by_sweep: dict[str, Any] = {}
    for row in curves.to_dict("records"):
        by_sweep.setdefault(row["sweep"], {})[f"{row['value']:g}"] = {name: row[name] for name in columns}
    first: Any = planes.iloc[0]
    return {
        "headline": states.to_dict("index"),
        "planes": {
            "distance_error_mm": first["distance_error_mm"],
            "normal_error_deg": first["normal_error_deg"],
        },
        "curves": by_sweep,
        "claims": {row["claim"]: int(row["value"]) for row in claims.to_dict("records")},
        "text": {
            row["quantity"]: float(row["published"])
            for row in judged.to_dict("records")
            if row["source"] == "headline" and row["rule"] == "reached"
        },
        "points": len(curves),
    }


def measured_later(followup: pd.DataFrame) -> dict[str, dict[str, float]]:
    """Return the errors of a real arm that the authors of the original paper published later: ``{error: {"before": value, "after": value}}``.

    Args:
        followup: published_followup.csv.
    """
    states: Any = followup.set_index("state")[["position_mean_mm", "position_max_mm"]]
    return states.to_dict()


def compared(parts: Mapping[str, Any]) -> dict[str, Any]:
    """Return ratios between numbers of the parts; the names of ratios have no unit.

    For the headline: the errors that the original paper states, and those of the initial model, over those of the proposed method.
    For the comparison of orders: the share of seeds in which a single pass is better, in the case of a good arm and few noisy data.
    """
    methods = parts["headline"]["methods"]
    proposed, initial = methods[PROPOSED], methods[INITIAL]
    found: dict[str, Any] = {
        "published_over_proposed": {
            _unitless(name): proposed["published"][name]["value"] / proposed["raw"][name]["mean"]
            for name in QUANTITIES
        },
        "initial_over_proposed": {
            _unitless(name): initial["raw"][name]["mean"] / proposed["raw"][name]["mean"]
            for name in QUANTITIES
        },
    }
    clip = methods.get(CLIPPED)
    if clip is not None:
        found["clip_over_proposed"] = {
            _unitless(name): clip["raw"][name]["mean"] / proposed["raw"][name]["mean"] for name in QUANTITIES
        }
    if "published_curves" in parts:
        chosen = [e for e in parts["published_curves"]["left_out"] if e["reason"] == LEFT_OUT]
        found["left_out"] = {e["sweep"]: int(e["value"]) for e in chosen}
        recovery = parts["published_curves"]["recovery"]
        found["recovery"] = {"curves": recovery["sets"] * len(recovery["by_candidate"])}
        found["sizes"] = _sizes(parts["published_curves"]["candidates"])
        found["workcells"] = _workcells(parts["published_curves"], found["published_over_proposed"])
    found["measured"] = measured_counts(parts.get("measured", {}).get("sets", {}))
    curve = sorted(map(float, parts["published"]["curves"]["noise"]))
    setup = parts["setup"]
    n_fixed = parts["headline"]["identifiability"]["zero_singular_values"]
    found["published_noise"] = {"low_mm": curve[0], "next_mm": curve[1]}
    few = min(map(int, parts["published"]["curves"]["poses"]))
    found["poses"] = {
        "equations_at_fewest": EQUATIONS_PER_POSE * few,
        "unknowns": setup["parameters_independent"] - n_fixed,
    }
    case = parts.get("sequential", {}).get("cases", {}).get("good-arm-few-noisy")
    if case:
        worse = case["ways"]["robot_first"]["one_pass"]["worse_than_at_once"]["position_mean"]
        found["sequential"] = {"one_pass_wins": 1.0 - worse}
    return found


def _sizes(candidates: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fitted magnitudes of each explanation, in the units of the paper: ``{name: {"1": {value, low, high, unit}}}``."""
    sizes: dict[str, Any] = {}
    for name, row in candidates.items():
        for k in ("1", "2"):
            if isinstance(row.get(f"unit_{k}"), str):
                unit, factor = SIZE_UNITS.get(row[f"unit_{k}"], (row[f"unit_{k}"], 1.0))
                of_one = {bound: row[f"{bound}_{k}"] * factor for bound in ("value", "low", "high")}
                sizes.setdefault(name, {})[k] = of_one | {"unit": unit}
    return sizes


def _workcells(curves: Mapping[str, Any], times: Mapping[str, float]) -> dict[str, Any]:
    """Return the factor by which errors differ between workcells, and how many standard deviations of its logarithm the published error lies off.

    Args:
        curves: The numbers of the study of the published curves.
        times: ``{quantity: ratio of the published error to that of the proposed method}``.
    """
    log_std = {_unitless(name): std for name, std in curves["offset_std"]["point"].items()}
    shifts = [offsets[QUANTITIES[0]] for offsets in curves["other_workcells"].values()]
    return {
        "count": len(shifts),
        "factor": {name: exp(std) for name, std in log_std.items()},
        "published_in_std": {name: log(times[name]) / std for name, std in log_std.items()},
        "least_factor": exp(min(shifts)) if shifts else None,
        "greatest_factor": exp(max(shifts)) if shifts else None,
    }


def _unitless(quantity: str) -> str:
    return quantity.rsplit("_", 1)[0]
