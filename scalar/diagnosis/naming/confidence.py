"""The confidence of an answer: the share of answers with similar evidence that were right in simulated trials.

The evidence alone does not give this probability. It would if one of the candidates were the true cause and all noise were Gaussian. In practice the
cause may be no effect of the catalogue, and scanners have errors that no model describes. The probability that an answer is right is therefore
estimated by a logistic regression on its grounds (``grounds``). The regression was fitted to answers on simulated data whose truth is known, with
scanners, trackers and probes, and imperfect scanners and unknown causes among them (``workflow/study/confidence``; the coefficients are in the
folder of this module). A feature outside the range of the trials is replaced by the nearest end of that range.

On the same grounds, some names are given wrongly more often than others, because more causes resemble them. The regression therefore has an offset
for each name, near zero unless the trials show otherwise; a name that was never given in the trials has no offset.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from scipy.special import expit

from scalar.diagnosis.naming.grounds import Grounds

COEFFICIENTS = "confidence_coefficients.json"  # written by `snakemake confidence`
REFERENCE_POSES = 100  # the number of poses enters as a ratio to this one
_LEAST_SHARE = 1e-3  # smaller numbers count as this one before their logarithm is taken
_NEAR_NATS = 20.0  # log odds over which ``rivalled`` falls to 1/e: chosen among 10, 20, 40 by the likelihood of trials left out of the fit


def features(grounds: Grounds) -> dict[str, float]:
    """Return the features of the regression by name; the log odds of being right are linear in them.

    The log odds of the answer and its least log odds enter by their signed logarithm. ``rivalled`` is 1 if a rival explains at least as much, and
    near 0 if none comes near. ``share`` is minus the logarithm of the share of the residual that the answer leaves; it counts less, the larger
    ``rivalled`` is. The numbers of poses and of other answers, the misfit, and the p-value of the autocorrelation (``chance``) enter by their
    logarithms. The last four features are 0 or 1: whether a flexible term was found as well, whether the same joint has further errors without a
    name, whether errors are correlated within scans, and whether the sensor scans.
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
        "poses": float(np.log(grounds.final_residuals.poses / REFERENCE_POSES)),
        "misfit": float(np.log(max(grounds.final_residuals.misfit, _LEAST_SHARE))),
        "chance": float(np.log(grounds.final_residuals.chance)),
        "others": float(np.log1p(grounds.others)),
        "beside_structure": float(grounds.beside_structure),
        "structure_there": float(grounds.structure_there),
        "correlated": float(grounds.final_residuals.correlated),
        "scans": float(grounds.final_residuals.scans),
    }


def confidence(grounds: Grounds, name: str) -> float:
    """Return the estimated probability that an answer is right, between 0 and 1.

    Args:
        grounds: The grounds of the answer.
        name: The name that the answer gives.
    """
    return logistic_probability(features(grounds), name, _coefficients()[grounds.kind])


def logistic_probability(values: Mapping[str, float], name: str, fitted: Mapping[str, Any]) -> float:
    """Return the probability that a fitted logistic regression gives.

    Args:
        values: The features.
        name: The name that the answer gives.
        fitted: ``intercept``; ``names``: the offset of each name; and ``features``: for each feature its ``coefficient``, and its range in the
            trials, ``from`` and ``to``.
    """
    total = fitted["intercept"] + fitted["names"].get(name, 0.0)
    for key, feature in fitted["features"].items():
        total += feature["coefficient"] * float(np.clip(values[key], feature["from"], feature["to"]))
    return float(expit(total))


@cache
def _coefficients() -> dict[str, Any]:
    return json.loads(resources.files("scalar.diagnosis.naming").joinpath(COEFFICIENTS).read_text("utf-8"))
