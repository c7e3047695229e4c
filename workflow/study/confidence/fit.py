"""Fit the confidence to the answers of trials, and report how often answers with a stated confidence are right.

The confidence that is reported of an answer follows from the fit to that half of the trials to which the answer does not belong (cross-fitting;
``study.confidence.answers`` divides the trials). The package uses the fit to both halves, which contains more causes than either.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from scipy.special import expit

from scalar.diagnosis.naming.confidence import REFERENCE_POSES, features, logistic_probability
from scalar.diagnosis.naming.grounds import COMPONENT, EFFECT, STRUCTURE, FinalResiduals, Grounds
from scalar.geometry.se3 import Array
from study.blind_trials.score import SURE
from study.blind_trials.statistics import wilson
from study.confidence.answers import HALVES

KINDS = (EFFECT, COMPONENT, STRUCTURE)
FEATURES = tuple(
    features(Grounds(EFFECT, 0.0, 0.0, 0.5, 0, False, False, FinalResiduals(1, 1.0, 1.0, False, True)))
)
"""Names of the features of an answer, in the order of the columns of a regression."""
SIGNS = {
    "log_odds": (0.0, None),
    "least_log_odds": (0.0, None),
    "rivalled": (None, 0.0),
    "share": (0.0, None),
}
"""``{feature: bounds of its coefficient}``: more evidence never makes an answer less sure, and a rival never makes it surer."""
BINS = (0.0, 0.5, 0.7, 0.8, 0.9, 1.0)
"""Edges of the bins of the stated confidence."""
FEW_POSES, MEDIUM_POSES = 60, 120
POSES = {
    "up_to_60": (0.0, FEW_POSES + 0.5),
    "up_to_120": (FEW_POSES + 0.5, MEDIUM_POSES + 0.5),
    "more": (MEDIUM_POSES + 0.5, np.inf),
}
"""``{class of sets: bounds of their number of poses}``."""
PRIOR = {EFFECT: 0.5, COMPONENT: 0.2, STRUCTURE: 1.0}
"""``{kind: prior standard deviation of a coefficient}``, for features of unit standard deviation.

Chosen among 0.1, 0.2, 0.3, 0.5 and 1 by the likelihood of that half of the answers to which each fit was not made. These numbers and ``NAME_PRIOR``
are the only ones that were chosen with the answers of all sets."""
NAME_PRIOR = 2.0
"""Prior standard deviation of the offset of a name; chosen among 0.5, 1 and 2 in the same way."""
_LEAST_STD = 1e-9  # a feature with a smaller standard deviation counts as constant


def fitted(answers: pd.DataFrame) -> dict[str, Any]:
    """Return ``{kind: coefficients}``, as ``scalar.diagnosis.naming.confidence.logistic_probability`` takes them.

    Answers of which several probably describe one cause (``repeated`` above 1, ``scalar.diagnosis.naming.repeated_changes``) are left out: their
    confidence is divided by that number.

    Args:
        answers: As ``answers_of`` and ``tracked_answers_of`` return them.
    """
    some: Any = answers[answers["repeated"] == 1]
    return {kind: regression(*_arrays(some[some["kind"] == kind]), PRIOR[kind]) for kind in KINDS}


def regression(X: Array, right: Array, named: Sequence[str], prior: float) -> dict[str, Any]:
    """Return a logistic regression with normal priors on the coefficients of standardised features and on the offsets of names.

    The signs of some coefficients are bounded (``SIGNS``). Without answers the confidence is one half.

    Args:
        X: ``(n, k)``, features in the order of ``FEATURES``.
        right: ``(n,)``, 0 or 1.
        named: The name that each of the n answers gives.
        prior: Standard deviation of the coefficients of features of unit standard deviation.
    """
    k = X.shape[1]
    centre, low, high = (f(X, axis=0) if len(X) else np.zeros(k) for f in (np.mean, np.min, np.max))
    std = np.std(X, axis=0) if len(X) else np.ones(k)
    std = np.where(std > _LEAST_STD, std, 1.0)
    names = sorted(set(named))
    of_name = np.array([[name == other for other in names] for name in named], dtype=float).reshape(
        len(X), -1
    )
    Z = np.column_stack([np.ones(len(X)), (X - centre) / std, of_name])
    precision = np.r_[0.0 if len(X) else 1.0, np.full(k, prior**-2), np.full(len(names), NAME_PRIOR**-2)]

    def cost(w: Array) -> tuple[float, Array]:
        odds = Z @ w
        value = float(np.sum(np.logaddexp(0.0, odds) - right * odds) + 0.5 * np.sum(precision * w * w))
        return value, Z.T @ (expit(odds) - right) + precision * w

    free = (None, None)
    bounds = [(-20.0, 20.0), *(SIGNS.get(name, free) for name in FEATURES), *(free for _ in names)]
    result: Any = minimize(cost, np.zeros(Z.shape[1]), jac=True, method="L-BFGS-B", bounds=bounds,
                           options={"ftol": 1e-14, "gtol": 1e-9, "maxiter": 10_000})  # fmt: skip
    slopes = result.x[1 : k + 1] / std
    return {
        "answers": len(X),
        "right": int(np.sum(right)),
        "intercept": float(result.x[0] - slopes @ centre),
        "names": dict(zip(names, result.x[k + 1 :].tolist(), strict=True)),
        "features": {
            name: {"coefficient": float(slope), "from": float(a), "to": float(b)}
            for name, slope, a, b in zip(FEATURES, slopes, low, high, strict=True)
        },
    }


def _arrays(some: Any) -> tuple[Array, Array, list[str]]:
    """Return the features ``(n, k)``, whether each answer is right ``(n,)`` (0 or 1), and the names that the answers give."""
    return some[list(FEATURES)].to_numpy(dtype=float), some["right"].to_numpy(dtype=float), list(some["name"])


def with_confidence(answers: pd.DataFrame) -> pd.DataFrame:
    """Return the answers with the column ``confidence``: that by the fit to the half to which the answer does not belong."""
    some: Any = answers
    by_half = {half: fitted(some[some["half"] != half]) for half in HALVES}
    stated = [
        logistic_probability(
            {str(key): value for key, value in row.items()}, row["name"], by_half[row["half"]][row["kind"]]
        )
        / row["repeated"]
        for row in answers.to_dict("records")
    ]
    return answers.assign(confidence=stated)


def reliability(stated: pd.DataFrame) -> pd.DataFrame:
    """Return, by kind and bins of the stated confidence, how many answers are right, with Wilson's interval."""
    rows = []
    for kind in KINDS:
        some: Any = stated[stated["kind"] == kind]
        value, right = some["confidence"].to_numpy(dtype=float), some["right"].to_numpy(dtype=bool)
        for low, high in pairwise(BINS):
            inside = (value >= low) & ((value < high) | (high == BINS[-1]))
            n, hits = int(inside.sum()), int(right[inside].sum())
            bottom, top = wilson(hits, n)
            rows.append(
                {"kind": kind, "from": low, "to": high, "answers": n}
                | {"mean_stated": float(value[inside].mean()) if n else None}
                | {"right": hits, "share": hits / n if n else None, "low": bottom, "high": top}
            )
    return pd.DataFrame(rows)


def reliability_by_poses(stated: pd.DataFrame) -> pd.DataFrame:
    """Return ``reliability`` for each class of sets in ``POSES``, with the class in the first column, ``poses``.

    Args:
        stated: As ``with_confidence`` returns them.
    """
    tables = []
    for name, some in by_poses(stated).items():
        table = reliability(some)
        table.insert(0, "poses", name)
        tables.append(table)
    return pd.concat(tables, ignore_index=True)


def by_poses(stated: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the answers of each class of sets in ``POSES``.

    Args:
        stated: Answers; their feature ``poses`` is the logarithm of the number of poses that were fitted over ``REFERENCE_POSES``.
    """
    some: Any = stated
    n_poses = REFERENCE_POSES * np.exp(some["poses"].to_numpy(dtype=float))
    return {name: some[(n_poses >= least) & (n_poses < most)] for name, (least, most) in POSES.items()}


def summary(stated: pd.DataFrame) -> dict[str, Any]:
    """Return for each kind of answer the Brier score of the confidence, the number of sure answers (``SURE`` or more), and of those that are wrong.

    ``brier_of_share`` is the Brier score if every answer stated the share of right answers of its kind. ``poses_`` and a class of ``POSES`` is the
    key of the numbers of answers, of sure ones and of those that are wrong in the sets of this class, for each kind. For sets with one effect, the
    numbers of right names, and of those that are sure, are added.

    Args:
        stated: As ``with_confidence`` returns them.
    """
    some: Any = stated
    content: dict[str, Any] = {"sure_from": SURE}
    for kind in KINDS:
        mine: Any = some[some["kind"] == kind]
        value, right = mine["confidence"].to_numpy(dtype=float), mine["right"].to_numpy(dtype=float)
        sure = value >= SURE
        content[kind] = {
            "answers": len(mine),
            "brier": float(np.mean((value - right) ** 2)) if len(mine) else None,
            "brier_of_share": float(np.var(right)) if len(mine) else None,
            "sure": int(sure.sum()),
            "sure_and_wrong": int(np.sum(1 - right[sure])),
        }
    for name, of_class in by_poses(stated).items():
        every: Any = of_class
        sure = every[every["confidence"] >= SURE]
        content[f"poses_{name}"] = {
            f"{kind}_{key}": int(count)
            for kind in KINDS
            for key, count in (
                ("answers", (every["kind"] == kind).sum()),
                ("sure", (sure["kind"] == kind).sum()),
                ("sure_and_wrong", ((sure["kind"] == kind) & ~sure["right"].astype(bool)).sum()),
            )
        }
    single: Any = some[
        (some["kind"] == EFFECT) & some["row"].isin(["one effect, ideal", "one effect, imperfect"])
    ]
    correct: Any = single[single["right"]]
    content["single_effects_right"] = len(correct)
    content["single_effects_right_and_sure"] = int((correct["confidence"] >= SURE).sum())
    return content
