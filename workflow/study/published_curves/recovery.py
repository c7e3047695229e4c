"""Test whether a known explanation is recovered: inject each candidate, simulate curves like the published ones, and compute the support by them.

The curves come from workcells that the predictions did not use (other seeds, other draws). Each run is a workcell of its
own, and a candidate has the size that the published curves give it. Two rates matter: how often the injected candidate is
not excluded, and how often a wrong candidate is excluded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from scalar.geometry.se3 import Array
from study.published_curves.candidates import Candidate
from study.published_curves.curves import Setting
from study.published_curves.ensemble import Ensemble
from study.published_curves.support import LEVELS, RefinedPrediction, weigh

INDISTINGUISHABLE = 3.0
"""Difference of log evidence (a factor of 20) below which two candidates are indistinguishable."""
EXCLUDED = float(np.log(1000.0))
"""Difference of log evidence above which the worse of two candidates is excluded."""


def inject(
    ensemble: Ensemble,
    candidate: Candidate,
    values: Sequence[float],
    settings: Sequence[Setting],
    sets: int,
    rng: np.random.Generator,
) -> Array:
    """Return log errors ``(sets, R, 4)`` of curves in which a candidate acts; every run is another workcell.

    Args:
        ensemble: Simulated workcells of seeds that the predictions did not use.
        candidate: The candidate to inject, one that is an effect.
        values: Its magnitudes [SI units].
        settings: The settings of the R runs.
        sets: Number of sets of curves.
        rng: Chooses the workcells.
    """
    y = np.empty((sets, len(settings), 4))
    for i in sorted(range(len(settings)), key=lambda i: (settings[i].design, settings[i].sigma)):
        ensemble.forget_others(settings[i])
        samples = ensemble.log_errors(settings[i], candidate.sizes(values))
        y[:, i] = samples[rng.integers(len(samples), size=sets)]
    return y


def inject_from_fits(refined: RefinedPrediction, sets: int, rng: np.random.Generator) -> Array:
    """Return log errors ``(sets, R, 4)`` drawn from the prediction of a sweep's fits; for candidates that are methods."""
    factor = np.linalg.cholesky(refined.covariance[0])
    return refined.mean[0] + np.einsum(
        "rij,srj->sri", factor, rng.standard_normal((sets, *refined.mean[0].shape))
    )


def recover(
    injected: Mapping[str, tuple[Array, Array]],
    refined_by_name: Mapping[str, RefinedPrediction],
    offset: Array,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the confusion, a row for each injected and each tried candidate, and the coverage, a row for each injected magnitude.

    Args:
        injected: ``{name of a candidate: (log errors of S sets of curves (S, R, 4), magnitudes (k,))}``.
        refined_by_name: ``{name: prediction}`` of all candidates that are tried.
        offset: ``(12, 12)``, covariance of the offset of the authors' workcell.
    """
    confusion, coverage = [], []
    for name, (curves, values) in injected.items():
        verdicts = {tried: weigh(refined, curves, offset) for tried, refined in refined_by_name.items()}
        evidence = np.array([[one.log_evidence for one in verdicts[tried]] for tried in refined_by_name])
        behind = evidence.max(axis=0) - evidence
        best = evidence.argmax(axis=0)
        for k, tried in enumerate(refined_by_name):
            confusion.append(
                {
                    "injected": name,
                    "tried": tried,
                    "sets": curves.shape[0],
                    "best": float((best == k).mean()),
                    "indistinguishable": float((behind[k] < INDISTINGUISHABLE).mean()),
                    "excluded": float((behind[k] > EXCLUDED).mean()),
                    "median_behind": float(np.median(behind[k])),
                }
            )
        for axis, magnitude in enumerate(refined_by_name[name].prediction.candidate.axes):
            truth, found = float(values[axis]), verdicts[name]
            ratio = np.array([one.median[axis] for one in found]) / truth
            row = {
                "injected": name,
                "magnitude": magnitude.name,
                "unit": magnitude.unit,
                "truth": truth * magnitude.factor,
                "median_found": float(np.median(ratio)) * truth * magnitude.factor,
                "spread_factor": float(np.exp(np.std(np.log(ratio)))),
            }
            for level in LEVELS:
                ends = np.array([one.intervals[level][axis] for one in found])
                inside = (ends[:, 0] <= truth) & (truth <= ends[:, 1])
                row[f"coverage_{round(100 * level)}"] = float(inside.mean())
            coverage.append(row)
    return pd.DataFrame(confusion), pd.DataFrame(coverage)
