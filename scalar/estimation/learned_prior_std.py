"""Estimate from the arm itself how far it is from its data sheet: one prior standard deviation for lengths, one for angles, one for joint zeros.

Corrections of lengths are draws from one normal distribution, those of angles and of joint zeros from two others. The marginal likelihood
gives their variances (MacKay, Neural Computation 4, 1992): with g_i the share of a correction m_i that the data determine,
``t^2 = sum(m_i^2) / sum(g_i)``. A few corrections do not determine a standard deviation, and a grid of poses may determine none. A stated
number of corrections of the size that is usual for arms is therefore counted with them, which is a scaled inverse chi-squared prior on the
variance (Gelman et al., Bayesian Data Analysis, 2013, 2.6).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from scalar.estimation.model import Model
from scalar.estimation.normal_equations import solved
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS, IdentifiabilitySettings
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.se3 import Array

_ROUNDS = 200
_SETTLED = 1e-3  # change of the logarithm of a standard deviation below which it has converged
_UNIT_INFORMATION = 1.0  # number of corrections that a weak prior counts as (Kass and Wasserman, J. American Statistical Association 90, 1995)
# Added to the squares of columns of unit length: it keeps the inverse finite where neither data nor priors determine a direction.
_RIDGE = 1e-14


@cache
def group_of(name: str) -> str:
    """Return ``length``, ``angle`` or ``zero`` for a parameter of the robot, and an empty string for any other."""
    kind = name.split("_")[0]
    if kind not in GEOMETRY:
        return ""
    return "length" if kind in LENGTHS else "zero" if kind == "theta" else "angle"


def learned_prior_stds(
    residuals: Residuals,
    model: Model,
    free: Array,
    settings: IdentifiabilitySettings = DEFAULTS.identifiability,
) -> dict[str, float]:
    """Return the standard deviation of the corrections of each group, ``{"length": m, "angle": rad, "zero": rad}``.

    Args:
        residuals: Of the dataset.
        model: At its optimum, with priors and its misfit ratio.
        free: ``(P,)`` bool.
        settings: Thresholds.
    """
    index = np.flatnonzero(free)
    names = [model.names[i] for i in index]
    normal, variance = residuals.normal_equations(model, free), model.misfit_ratio**2
    means, stds = np.zeros(len(index)), np.full(len(index), np.inf)
    at = {name: k for k, name in enumerate(names)}
    for prior in model.priors:
        if prior.name in at:
            means[at[prior.name]], stds[at[prior.name]] = prior.mean, prior.std
    corrections = np.where(np.isfinite(stds), model.vector[index] - means, 0.0)
    group = np.array([group_of(name) for name in names])
    groups = {g: group == g for g in ("length", "angle", "zero")}
    return most_likely_prior_stds(
        normal.gram / variance,
        normal.gradient / variance,
        corrections,
        stds,
        groups,
        typical_prior_stds(settings),
    )


def typical_prior_stds(settings: IdentifiabilitySettings) -> dict[str, tuple[float, float]]:
    """Return for each group the usual standard deviation [m or rad] of an arm's corrections, and how many corrections it counts as."""
    return {
        "length": (settings.typical_link, settings.typical_count),
        "angle": (settings.typical_link, settings.typical_count),
        "zero": (settings.typical_zero, _UNIT_INFORMATION),
    }


def most_likely_prior_stds(
    gram: Array,
    gradient: Array,
    corrections: Array,
    stds: Array,
    groups: Mapping[str, Array],
    typical: Mapping[str, tuple[float, float]],
) -> dict[str, float]:
    """Return the prior standard deviations of greatest marginal likelihood of a linear model, by MacKay's fixed point.

    Args:
        gram: ``(F, F)``, J'J of the whitened rows divided by the misfit ratio.
        gradient: ``(F,)``, J'r of the same rows, at these corrections.
        corrections: ``(F,)`` [m or rad], the corrections at which the model was linearised.
        stds: ``(F,)``, prior standard deviations, infinite where there is no prior.
        groups: For each group ``(F,)`` bool, which corrections belong to it.
        typical: For each group the usual standard deviation [m or rad] and the number of corrections that it counts as.
    """
    belongs = np.array([groups[g] for g in groups], dtype=float)  # (groups, F)
    prior, count = np.array([typical[g] for g in groups]).T
    prior_stds, in_none = prior, ~belongs.any(axis=0)
    weight_elsewhere = np.where(in_none, 1.0 / stds**2, 0.0)
    for _ in range(_ROUNDS):
        weight = weight_elsewhere + (1.0 / prior_stds**2) @ belongs
        H = gram.copy()
        diagonal = H.ravel()[:: len(H) + 1]  # a view
        diagonal += weight
        scale = 1.0 / np.sqrt(np.maximum(diagonal, 1e-300))
        H *= scale[:, None] * scale
        diagonal += _RIDGE
        step, variance = solved(H, scale * (gradient + weight * corrections))
        m = corrections - scale * step
        determined = belongs @ (1.0 - weight * variance * scale**2)
        new = np.sqrt((belongs @ m**2 + count * prior**2) / (np.maximum(determined, 0.0) + count))
        change = np.max(np.abs(np.log(new / prior_stds)))
        prior_stds = new
        if change < _SETTLED:
            break
    return dict(zip(groups, prior_stds.tolist(), strict=True))
