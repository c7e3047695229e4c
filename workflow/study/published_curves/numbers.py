"""Collect the numbers of the explanation of the published curves that the paper quotes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from study.common.statistics import QUANTITIES
from study.published_curves.candidates import STATED
from study.published_curves.curves import Curves
from study.published_curves.findings import WAYS
from study.published_curves.predict import Predictions
from study.published_curves.recovery import EXCLUDED, INDISTINGUISHABLE

OF_SOLVER = ("iterations", "tolerance")
"""Magnitudes that are no errors of measurement, but settings of the solver."""
_SINGLE = ("noise", "shared", "scan", "joint", "step", "iterations", "tolerance", "abs", "abs-2018", "clip")
"""Names of the single effects, of which pairs consist, and of the readings of the baseline's square root."""


def summary_numbers(
    curves: Curves,
    candidates: pd.DataFrame,
    confusion: pd.DataFrame,
    coverage: pd.DataFrame,
    predicted: Predictions,
    options: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the numbers that the paper quotes.

    Args:
        curves: The published runs.
        candidates: As ``candidate_table`` returns it.
        confusion: As ``recovery.recover`` returns it.
        coverage: As ``recovery.recover`` returns it.
        predicted: The predictions of the candidates.
        options: The config's block ``published_curves``.
    """
    records = {str(row["candidate"]): row for row in _records(candidates)}
    tested = {name: row for name, row in records.items() if row["verdict"] != "not_tested"}
    ranked = sorted(tested, key=lambda name: -tested[name]["log_evidence"])
    verdicts = {
        verdict: [name for name in ranked if tested[name]["verdict"] == verdict]
        for verdict in ("supported", "disfavoured", "excluded")
    }
    with_effect = {
        effect: float(sum(row["posterior"] for name, row in tested.items() if effect in name.split("+")))
        for effect in _SINGLE
    }
    return {
        "runs": len(curves.settings),
        "values": int(curves.log_errors.size),
        "left_out": [
            {"sweep": row["sweep"], "value": float(row["value"]), "reason": row["reason"]}
            for row in _records(curves.left_out)
        ],
        "seeds": options["seeds"],
        "candidates_tested": len(tested),
        "not_tested": [name for name, row in records.items() if row["verdict"] == "not_tested"],
        "best": ranked[0],
        "best_single": next(name for name in ranked if tested[name]["magnitudes"] < 2),
        "ranked": ranked,
        **verdicts,
        "posterior_with_effect": with_effect,
        "misfit_factor_stated": tested[STATED]["misfit_factor"],
        "misfit_factor_stated_with_offset": tested[STATED]["misfit_factor_with_offset"],
        "misfit_factor_best": tested[ranked[0]]["misfit_factor"],
        "misfit_factor_best_with_offset": tested[ranked[0]]["misfit_factor_with_offset"],
        "indistinguishable_below": INDISTINGUISHABLE,
        "excluded_above": EXCLUDED,
        "offset_std": {
            group: _by_quantity(row)
            for group, row in zip(
                ("point", "scan", "joint"),
                np.sqrt(np.diag(predicted.offset)).reshape(3, -1).tolist(),
                strict=True,
            )
        },
        "other_workcells": {name: _by_quantity(row) for name, row in predicted.others.items()},
        "candidates": {name: _plain(row) for name, row in tested.items()},
        "leaders": _leaders(tested),
        "recovery": {"sets": options["recovery_sets"], **_recovery(confusion, coverage)},
    }


def _by_quantity(row: Sequence[float]) -> dict[str, float]:
    """Return ``{quantity: its number}``."""
    return dict(zip(QUANTITIES, row, strict=True))


def _recovery(confusion: pd.DataFrame, coverage: pd.DataFrame) -> dict[str, Any]:
    """Return how often candidates are recovered from simulated curves, and how often their intervals contain the true magnitudes.

    Args:
        confusion, coverage: As ``recovery.recover`` returns them.

    Returns:
        Shares. ``coverage_68`` and ``coverage_95`` are of the sizes of errors; of those of the solver, its tolerance and its number of iterations,
        ``coverage_95_of_solver`` has the least and the greatest.
    """
    own: Any = confusion[confusion["injected"] == confusion["tried"]]
    wrong: Any = confusion[confusion["injected"] != confusion["tried"]]
    every: Any = coverage
    solver = every["magnitude"].isin(OF_SOLVER)
    of_solver, of_errors = every[solver], every[~solver]
    return {
        "true_one_best": _mean(own, "best"),
        "true_one_indistinguishable": _mean(own, "indistinguishable"),
        "true_one_excluded": _mean(own, "excluded"),
        "wrong_one_excluded": _mean(wrong, "excluded"),
        "coverage_68": _mean(of_errors, "coverage_68"),
        "coverage_95": _mean(of_errors, "coverage_95"),
        "coverage_95_of_solver": {
            "least": float(of_solver["coverage_95"].min()),
            "greatest": float(of_solver["coverage_95"].max()),
        },
        "by_candidate": {
            row["injected"]: {key: row[key] for key in ("best", "indistinguishable", "excluded")}
            for row in _records(own)
        },
    }


def _leaders(tested: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Return ``{way of weighing: candidate with the largest evidence}``."""
    ways = ["behind", *(f"behind_{way}" for way in WAYS)]
    return {way: min(tested, key=lambda name: tested[name][way]) for way in ways}


def _plain(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row's numbers and texts without those that are missing."""
    return {key: value for key, value in row.items() if isinstance(value, (str, bool)) or np.isfinite(value)}


def _records(table: Any) -> list[dict[str, Any]]:
    """Return the rows of a table as mappings."""
    return table.to_dict("records")


def _mean(table: Any, column: str) -> float:
    return float(table[column].mean())
