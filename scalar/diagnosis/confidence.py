"""How sure an answer is: how often answers with such grounds have been right.

The evidence alone is no chance. It would be one if the truth were among what was tried, and nothing but Gaussian noise in addition; neither
need be: causes have no known name, scanners err in ways of their own. So the chance that an answer is right is a logistic regression on its
grounds, fitted to answers about simulated data whose truth is known, imperfect scanners and unknown causes among them
(``workflow/study/blind_trials/confidence_fit.py``; the coefficients stand beside this module). An answer with grounds beyond those that
were tried is judged as if it had the nearest tried ones.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from scipy.special import expit

from scalar.diagnosis.grounds import Grounds

COEFFICIENTS = "confidence_coefficients.json"  # written by `snakemake confidence`
_FEW, _LEAST_SHARE = 100, 1e-3
_NEAR_NATS = 20.0  # within which something else explains nearly as much: chosen among 10, 20, 40 by the likelihood of trials not fitted to


def features(grounds: Grounds) -> dict[str, float]:
    """Return the numbers, by their names, on which the log odds of being right depend linearly.

    The share that an answer explains counts only as far as nothing else explains nearly as much.
    """
    odds = grounds.log_odds
    rivalled = float(np.exp(-max(odds, 0.0) / _NEAR_NATS))
    explained = -float(np.log1p(-min(max(grounds.share, 0.0), 1 - _LEAST_SHARE)))
    least = grounds.least_log_odds
    return {
        "log_odds": float(np.sign(odds) * np.log1p(abs(odds))),
        "least_log_odds": float(np.sign(least) * np.log1p(abs(least))),
        "rivalled": rivalled,
        "share": (1.0 - rivalled) * explained,
        "poses": float(np.log(grounds.left.poses / _FEW)),
        "misfit": float(np.log(max(grounds.left.misfit, _LEAST_SHARE))),
        "chance": float(np.log(grounds.left.chance)),
        "others": float(np.log1p(grounds.others)),
        "beside_structure": float(grounds.beside_structure),
        "correlated": float(grounds.left.correlated),
    }


def confidence(grounds: Grounds) -> float:
    """Return the chance that an answer is right, between 0 and 1."""
    return predicted(features(grounds), _coefficients()[grounds.kind])


def predicted(values: Mapping[str, float], fitted: Mapping[str, Any]) -> float:
    """Return the chance that a fitted logistic regression gives.

    Args:
        values: The features.
        fitted: ``intercept`` and, in ``features``, for each ``coefficient`` and the range that was tried, ``from`` and ``to``.
    """
    total = fitted["intercept"]
    for name, feature in fitted["features"].items():
        total += feature["coefficient"] * float(np.clip(values[name], feature["from"], feature["to"]))
    return float(expit(total))


@cache
def _coefficients() -> dict[str, Any]:
    return json.loads(resources.files("scalar.diagnosis").joinpath(COEFFICIENTS).read_text("utf-8"))
