"""Weigh each candidate by the published curves, and test by injected candidates which of them this method distinguishes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.geometry.se3 import Array
from study.published_curves.candidates import CANDIDATES, STATED, predict_from_fits
from study.published_curves.curves import Curves
from study.published_curves.ensemble import build_ensemble
from study.published_curves.findings import candidate_table, prediction_table
from study.published_curves.numbers import summary_numbers
from study.published_curves.predict import Predictions, runs_to_weigh
from study.published_curves.recovery import inject, inject_from_fits, recover
from study.published_curves.support import RefinedPrediction, Support, refine, weigh

LEAST_GAIN = 2.0
"""Least gain in log likelihood [nats] over the stated noise alone for which the fitted magnitude of a candidate is injected."""
FIRST_SEED = 1000
"""First seed of the workcells of injected curves; the predictions use smaller seeds."""


@dataclass(frozen=True)
class Findings:
    """The outputs of this study.

    Attributes:
        candidates: A row for each candidate, as ``candidate_table`` returns it.
        predictions: A row for each candidate, run and quantity, as ``prediction_table`` returns it.
        recovery: A row for each injected and each tried candidate, the confusion that ``recover`` returns.
        coverage: A row for each injected magnitude, the coverage that ``recover`` returns.
        numbers: The numbers that the paper quotes, as ``summary_numbers`` returns them.
    """

    candidates: pd.DataFrame
    predictions: pd.DataFrame
    recovery: pd.DataFrame
    coverage: pd.DataFrame
    numbers: dict[str, Any]


def explain_published_curves(
    scene: str | Path,
    published: pd.DataFrame,
    sweeps: Mapping[str, pd.DataFrame],
    predicted: Predictions,
    options: Mapping[str, Any],
) -> Findings:
    """Return the support of every candidate by the published curves, and the recovery of injected candidates.

    Args:
        scene: Config file of the original paper's workcell.
        published: published_curves.csv.
        sweeps: ``{sweep: its errors.csv}``.
        predicted: The predictions, as ``predict_runs`` returns them.
        options: The config's block ``published_curves``; its schema describes the keys.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    from scalar.simulation.config import load_config

    scene = Path(scene)
    config = load_config(scene)
    curves = runs_to_weigh(config, published, options)
    predictions, offset = dict(predicted.predictions), predicted.offset
    for candidate in CANDIDATES:
        if candidate.method:
            found = predict_from_fits(candidate, curves, sweeps, options["walls"])
            if found is not None:
                predictions[candidate.name] = found
    predictions = {c.name: predictions[c.name] for c in CANDIDATES if c.name in predictions}
    refined_by_name = {name: refine(prediction) for name, prediction in predictions.items()}
    verdicts = {
        name: weigh(refined, curves.log_errors[None], offset)[0] for name, refined in refined_by_name.items()
    }
    candidates = candidate_table(curves, predictions, refined_by_name, verdicts, offset)
    print("injecting the candidates, to test their recovery", flush=True)
    confusion, coverage = _recovery(config, scene.parent, curves, refined_by_name, verdicts, offset, options)
    return Findings(
        candidates=candidates,
        predictions=prediction_table(curves, refined_by_name, verdicts, offset),
        recovery=confusion,
        coverage=coverage,
        numbers=summary_numbers(curves, candidates, confusion, coverage, predicted, options),
    )


def _recovery(
    config: Mapping[str, Any],
    base_dir: Path,
    curves: Curves,
    refined_by_name: Mapping[str, RefinedPrediction],
    verdicts: Mapping[str, Support],
    offset: Array,
    options: Mapping[str, Any],
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return confusion and coverage, with every candidate injected in the size that the curves give it."""
    values = {name: verdicts[name].best for name in refined_by_name}
    for name, refined in refined_by_name.items():
        # A candidate that does not help, or whose fitted size is at the end of its range, is injected in the middle of that range.
        useless = verdicts[name].log_peak < verdicts[STATED].log_peak + LEAST_GAIN
        if useless or verdicts[name].at_edge.any():
            axes = refined.prediction.candidate.axes
            values[name] = np.array([axis.values[len(axis.values) // 2] for axis in axes])
    steps = {
        float(v)
        for name, refined in refined_by_name.items()
        for axis, v in zip(refined.prediction.candidate.axes, values[name], strict=True)
        if axis.name == "step"
    }
    count = options["recovery_seeds"]
    fresh = build_ensemble(
        config,
        base_dir,
        range(FIRST_SEED, FIRST_SEED + count),
        options["draws"],
        curves.settings,
        sorted(steps),
        min(count, options["followed_seeds"]),
    )
    rng = np.random.default_rng(FIRST_SEED)
    injected = {}
    for name, refined in refined_by_name.items():
        candidate, sets = refined.prediction.candidate, options["recovery_sets"]
        if candidate.method:
            y = inject_from_fits(refined, sets, rng)
        else:
            y = inject(fresh, candidate, values[name].tolist(), curves.settings, sets, rng)
        injected[name] = y, values[name]
    return recover(injected, refined_by_name, offset)
