"""Tabulate the support of the candidates and what they predict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import logsumexp

from scalar.geometry.se3 import Array
from study.common.statistics import QUANTITIES
from study.published_curves.candidates import CANDIDATES, Candidate, Prediction
from study.published_curves.curves import Curves
from study.published_curves.recovery import EXCLUDED, INDISTINGUISHABLE
from study.published_curves.support import (
    ALL,
    RefinedPrediction,
    Support,
    held_out,
    offsets_found,
    refine,
    weigh,
)

MEANS = (0, 2)  # indices in QUANTITIES of the mean errors
FEW_POSES = 25  # with fewer poses, the least observable directions of the parameters dominate the errors
LARGE_NOISE = 2.0  # multiple of the median noise: the published curves bend below it, and runs with more noise say little about the cause
Z95 = 1.645  # standard deviations from the median to the 95 % quantile of a normal distribution

WAYS = (
    "workcells_twice_as_different",
    "workcells_half_as_different",
    "mean_errors_only",
    "without_few_poses",
    "without_single_points",
    "without_points_curve",
    "without_large_noise",
)
"""Other reasonable ways of weighing the runs; a ranking that changes with one of them is no finding."""


def ways_to_weigh(curves: Curves, offset: Array) -> dict[str, tuple[tuple[int, ...], Array, Array | None]]:
    """Return ``{way: (quantities, offset, runs)}`` for every one of ``WAYS``.

    Args:
        curves: The published runs.
        offset: ``(12, 12)``, covariance of the offset of the authors' workcell.

    Returns:
        The indices of the quantities that are used, the covariance of the offset, and ``(R,)`` bool, the runs that are used (None: all).
    """
    enough = np.array([setting.poses >= FEW_POSES for setting in curves.settings])
    several = np.array([setting.points > 1 for setting in curves.settings])
    median_noise = np.median([setting.sigma for setting in curves.settings])
    quiet = np.array([setting.sigma <= LARGE_NOISE * median_noise for setting in curves.settings])
    not_points = curves.table["sweep"].to_numpy() != "points"
    return {
        "workcells_twice_as_different": (ALL, 4.0 * offset, None),
        "workcells_half_as_different": (ALL, 0.25 * offset, None),
        "mean_errors_only": (MEANS, offset, None),
        "without_few_poses": (ALL, offset, enough),
        "without_single_points": (ALL, offset, several),
        "without_points_curve": (ALL, offset, not_points),
        "without_large_noise": (ALL, offset, quiet),
    }


def candidate_table(
    curves: Curves,
    predictions: Mapping[str, Prediction],
    refined_by_name: Mapping[str, RefinedPrediction],
    verdicts: Mapping[str, Support],
    offset: Array,
) -> pd.DataFrame:
    """Return a row for each candidate: its fitted magnitudes, misfit, evidence, held-out curves and verdict; logarithms are natural ones.

    Args:
        curves: The published runs.
        predictions: ``{candidate: its prediction}``.
        refined_by_name: ``{candidate: its prediction on the refined grid}``.
        verdicts: ``{candidate: its support}`` if all runs and quantities are used.
        offset: ``(12, 12)``, covariance of the offset of the authors' workcell.
    """
    evidence = {
        "all": {name: one.log_evidence for name, one in verdicts.items()},
        **_evidence_otherwise(curves, predictions, refined_by_name, offset),
    }
    behind = {
        way: {name: max(values.values()) - value for name, value in values.items()}
        for way, values in evidence.items()
    }
    total = float(logsumexp(list(evidence["all"].values())))
    rows = []
    for candidate in CANDIDATES:
        name = candidate.name
        row: dict[str, Any] = {
            "candidate": name,
            "label": candidate.label,
            "magnitudes": len(candidate.magnitudes),
        }
        if name not in refined_by_name:
            rows.append(row | {"verdict": "not_tested"})
            continue
        refined, one = refined_by_name[name], verdicts[name]
        of_candidate = {way: values[name] for way, values in behind.items()}
        rows.append(
            row
            | _magnitudes(candidate, one)
            | _misfit(curves, refined, one, offset)
            | _evidence(candidate, one, of_candidate, total)
            | _held_out(curves, refined, offset)
        )
    return pd.DataFrame(rows)


def _evidence_otherwise(
    curves: Curves,
    predictions: Mapping[str, Prediction],
    refined_by_name: Mapping[str, RefinedPrediction],
    offset: Array,
) -> dict[str, dict[str, float]]:
    """Return ``{way of weighing: {candidate: log evidence}}`` for every one of ``WAYS``; arguments as for ``candidate_table``."""
    evidence = {}
    for way, (quantities, offset_covariance, runs) in ways_to_weigh(curves, offset).items():
        finer = (
            refined_by_name
            if quantities == ALL
            else {name: refine(one, quantities) for name, one in predictions.items()}
        )
        evidence[way] = {
            name: weigh(one, curves.log_errors[None], offset_covariance, runs)[0].log_evidence
            for name, one in finer.items()
        }
    return evidence


def _magnitudes(candidate: Candidate, support: Support) -> dict[str, Any]:
    """Return the cells on the fitted magnitudes of a candidate, with their 95 % intervals."""
    cells: dict[str, Any] = {}
    for number, axis in enumerate(candidate.axes, start=1):
        cells |= {
            f"magnitude_{number}": axis.name,
            f"unit_{number}": axis.unit,
            f"value_{number}": support.median[number - 1] * axis.factor,
            f"low_{number}": support.intervals[0.95][number - 1, 0] * axis.factor,
            f"high_{number}": support.intervals[0.95][number - 1, 1] * axis.factor,
            f"at_edge_{number}": bool(support.at_edge[number - 1]),
        }
    return cells


def _misfit(curves: Curves, refined: RefinedPrediction, support: Support, offset: Array) -> dict[str, Any]:
    """Return the cells on how far a candidate's best prediction is from the curves, with and without the offset of the authors' workcell."""
    residual = curves.log_errors - refined.mean[support.node]
    delta = offsets_found(refined, support.node, support.kappa, curves.log_errors, offset)
    return {
        "scatter_factor": support.kappa,
        "misfit_factor": _factor(residual),
        "misfit_factor_with_offset": _factor(residual - delta),
        "offset_size": float(np.exp(np.abs(delta).max())),
    }


def _evidence(
    candidate: Candidate, support: Support, behind: Mapping[str, float], total: float
) -> dict[str, Any]:
    """Return the cells on a candidate's evidence and its verdict.

    Args:
        candidate: The candidate.
        support: Its support if all runs and quantities are used.
        behind: ``{way of weighing: by how much its log evidence is behind the best one}``, ``all`` first.
        total: Log of the sum of the evidences of all candidates.
    """
    ways = list(behind.values())
    return {
        "log_likelihood": support.log_peak,
        "aic": 2.0 * (len(candidate.magnitudes) + 1) - 2.0 * support.log_peak,
        "log_evidence": support.log_evidence,
        "behind": behind["all"],
        "posterior": float(np.exp(support.log_evidence - total)),
        "behind_least": min(ways),
        "behind_most": max(ways),
        "verdict": _verdict(behind["all"], ways),
        **{f"behind_{way}": value for way, value in behind.items() if way != "all"},
    }


def _held_out(curves: Curves, refined: RefinedPrediction, offset: Array) -> dict[str, float]:
    """Return the cells on the log likelihood of each curve that is held out, and their sum."""
    apart = held_out(refined, curves.log_errors, offset, curves.table["sweep"].to_numpy())
    return {
        **{f"held_out_{name}": value for name, value in apart.items()},
        "held_out": sum(apart.values()),
    }


def _verdict(behind: float, ways: Sequence[float]) -> str:
    """Return ``supported``, ``excluded`` or ``disfavoured``.

    A candidate is supported if its log evidence is indistinguishable from the best one (``behind`` it with all runs), and excluded if it lies more
    than ``EXCLUDED`` behind by every one of the ``ways`` of weighing.
    """
    if behind < INDISTINGUISHABLE:
        return "supported"
    return "excluded" if min(ways) > EXCLUDED else "disfavoured"


def _factor(log_ratio: Array) -> float:
    """Return the root mean square of log ratios as a factor; 1 means no misfit."""
    return float(np.exp(np.sqrt(np.mean(log_ratio**2))))


def prediction_table(
    curves: Curves,
    refined_by_name: Mapping[str, RefinedPrediction],
    verdicts: Mapping[str, Support],
    offset: Array,
) -> pd.DataFrame:
    """Return for every candidate, run and quantity the median and the 5 and 95 % quantiles that are predicted at the best magnitudes.

    Args:
        curves: The published curves.
        refined_by_name: ``{candidate: its prediction on the finer grid}``.
        verdicts: ``{candidate: its support by the curves}``.
        offset: ``(12, 12)``, covariance of the errors that the authors' unknown workcell adds to all runs (``log_likelihood``).
    """
    rows = []
    for name, refined in refined_by_name.items():
        one = verdicts[name]
        delta = offsets_found(refined, one.node, one.kappa, curves.log_errors, offset)
        std = one.kappa * np.sqrt(np.diagonal(refined.covariance[one.node], axis1=-2, axis2=-1))
        for r, run in enumerate(curves.table.to_dict("records")):
            for q, quantity in enumerate(QUANTITIES):
                plain = refined.mean[one.node, r, q]
                middle = plain + delta[r, q]
                rows.append(
                    {
                        "candidate": name,
                        "sweep": run["sweep"],
                        "value": run["value"],
                        "quantity": quantity,
                        "published": float(run[quantity]),
                        "without_offset": float(np.exp(plain)),
                        "median": float(np.exp(middle)),
                        "p05": float(np.exp(middle - Z95 * std[r, q])),
                        "p95": float(np.exp(middle + Z95 * std[r, q])),
                    }
                )
    return pd.DataFrame(rows)
