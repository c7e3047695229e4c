"""Compute the support of each reading of the baseline's square root if walls lean, and that of all explanations if no published run is left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.geometry.se3 import Array
from study.common.methods import CONVERGED
from study.published_curves.candidates import Candidate, Prediction, predict_from_fits
from study.published_curves.curves import Curves
from study.published_curves.findings import ways_to_weigh
from study.published_curves.leaning_walls import READINGS, all_runs
from study.published_curves.predict import predict_runs, runs_to_weigh
from study.published_curves.support import ALL, refine, weigh

WITH_LEFT_OUT = "with_the_run_left_out"
"""Name of the way of weighing that also uses the published runs which the config leaves out."""
_WALLS = "leaning"  # kind of walls in the tables of fits


def weigh_leaning_walls(
    scene: str | Path, published: pd.DataFrame, fits: pd.DataFrame, options: Mapping[str, Any]
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Return how far each explanation lies behind the best: a row for each explanation, lean and way of weighing; and the paper's numbers.

    Args:
        scene: Config file of the original paper's workcell.
        published: published_curves.csv.
        fits: The tables that ``fit_leaning_walls`` returns for all leans, joined.
        options: The config's block ``published_curves``, and ``first_seed``.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    from scalar.simulation.config import load_config

    config = load_config(Path(scene))
    every, usual = all_runs(config, published, options), runs_to_weigh(config, published, options)
    predicted = predict_runs(scene, published, {**options, "leave_out": {}})
    kept = np.isin(_names(every), _names(usual))
    ways: dict[str, tuple[Curves, tuple[int, ...], Array, Array | None]] = {
        "all": (usual, ALL, predicted.offset, None)
    }
    ways |= {name: (usual, *way) for name, way in ways_to_weigh(usual, predicted.offset).items()}
    ways[WITH_LEFT_OUT] = every, ALL, predicted.offset, None
    from_fits = {len(curves.settings): dict(_from_fits(fits, curves)) for curves in (usual, every)}
    rows: list[dict[str, Any]] = []
    for way, (curves, quantities, offset, runs) in ways.items():
        predictions = {
            (name, None): one if curves is every else _of_runs(one, kept)
            for name, one in predicted.predictions.items()
        } | from_fits[len(curves.settings)]
        evidence = {
            key: weigh(refine(one, quantities), curves.log_errors[None], offset, runs)[0].log_evidence
            for key, one in predictions.items()
        }
        best = max(evidence.values())
        rows += [
            {"way": way, "explanation": name, "lean_deg": lean, "behind": best - value}
            for (name, lean), value in evidence.items()
        ]
    table = pd.DataFrame(rows)
    return table, _numbers(table, fits, len(usual.settings), len(every.settings))


def _names(curves: Curves) -> list[str]:
    """Return a name for each run, by which the same run is found in other curves."""
    return [f"{row['sweep']} {row['value']}" for row in curves.table.to_dict("records")]


def _of_runs(prediction: Prediction, kept: Array) -> Prediction:
    """Return a prediction restricted to some of its R runs, those with ``kept`` ``(R,)`` True."""
    return replace(
        prediction,
        mean=prediction.mean[:, kept],
        covariance=prediction.covariance[:, kept],
        shares=prediction.shares[:, kept],
    )


def _from_fits(fits: pd.DataFrame, curves: Curves) -> Any:
    """Yield ``((reading, lean), prediction)`` for readings and leans with enough converged fits of every run."""
    for lean, of_lean in fits.groupby("lean_deg", sort=True):
        by_sweep: dict[str, Any] = {
            str(sweep): rows.assign(walls=_WALLS) for sweep, rows in of_lean.groupby("sweep")
        }
        for method, label in READINGS.items():
            found = predict_from_fits(Candidate(method, label, method=method), curves, by_sweep, _WALLS)
            if found is not None:
                yield (method, float(lean)), found  # type: ignore[arg-type]


def _numbers(table: pd.DataFrame, fits: pd.DataFrame, usual: int, every: int) -> dict[str, Any]:
    """Return the numbers that the paper quotes: for each reading a list over the leans, and for each explanation how far it lies behind the best
    if no run is left out.
    """
    leans = sorted(map(float, fits["lean_deg"].unique()))
    readings: dict[str, Any] = {}
    for method, label in READINGS.items():
        of_method: Any = table[table["explanation"] == method]
        entries = []
        for lean in leans:
            here = of_method[of_method["lean_deg"] == lean].set_index("way")["behind"]
            done = fits[(fits["method"] == method) & (fits["lean_deg"] == lean)]
            few = {"behind": None, "behind_least": None, "behind_most": None}
            own = here.drop(WITH_LEFT_OUT, errors="ignore")
            entries.append(
                {
                    "lean_deg": lean,
                    "seeds": len(set(done["seed"])),
                    "fits": len(done),
                    "not_converged": int(np.count_nonzero(done["status"] != CONVERGED)),
                }
                | (
                    {"behind": here["all"], "behind_least": own.min(), "behind_most": own.max()}
                    if len(own)
                    else few
                )
            )
        readings[method] = {"label": label, "leans": entries}
    left_out: Any = table[(table["way"] == WITH_LEFT_OUT) & table["lean_deg"].isna()]
    behind = dict(zip(left_out["explanation"], left_out["behind"], strict=True))
    upright: Any = table[(table["way"] == WITH_LEFT_OUT) & (table["lean_deg"] == 0)]
    behind |= dict(zip(upright["explanation"], upright["behind"], strict=True))
    noise: Any = fits[(fits["sweep"] == "noise") & (fits["status"] == CONVERGED)]
    quiet = noise[noise["value"] == noise["value"].min()]
    medians: Any = quiet.groupby(["lean_deg", "method"])["position_mean_mm"].median()
    ends = medians.groupby("lean_deg").agg(["min", "max"]).reindex(leans)
    leaning = [float(b) for b in table.loc[table["lean_deg"] > 0, "behind"]]
    return {
        "seeds": len(set(fits["seed"])),
        "least_behind_leaning": min(leaning, default=None),
        "smallest_noise": [
            {"position_mean_least_mm": float(least), "position_mean_most_mm": float(most)}
            for least, most in ends.to_numpy()
        ],
        "runs": usual,
        "runs_with_those_left_out": every,
        "fits": len(fits),
        "leans_deg": leans,
        "readings": readings,
        "behind_with_the_run_left_out": behind,
    }
