"""Compute how much the errors differ between workcells: the uncertainty that the authors' unknown workcell adds to every prediction.

The original paper states neither ranges nor fan, nor where the target planes stand. A different workcell shifts whole curves, all runs alike, and
this shift must not decide between candidates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from scalar.geometry.se3 import Array
from study.common.grid import with_overrides
from study.published_curves.curves import Setting
from study.published_curves.ensemble import Sizes, build_ensemble

_ONE_EFFECT = (
    Sizes(),
    Sizes(noise=0.0, scan=1e-4),
    Sizes(noise=0.0, joint=1e-4),
)
"""Errors of points, of scans [m] and of joints [rad] alone; the differences of log errors do not depend on their sizes."""
_LEAST_VARIANCE = 0.05**2  # added variance of a log error: workcells differ in more ways than were tried


def offset_covariance(
    config: Mapping[str, Any],
    base_dir: Path,
    others: Mapping[str, Mapping[str, Any]],
    base: Setting,
    seeds: Sequence[int],
    draws: int,
) -> tuple[Array, dict[str, list[float]]]:
    """Return the second moment ``(12, 12)`` of the differences of log errors between other workcells and this one, and ``{name: mean differences}``.

    The 12 coordinates are the four quantities for errors of points, of scans and of joints, since a narrow fan enlarges some and not others.

    Args:
        config: Config of this project's scene.
        base_dir: Folder from which the path of the scene's robot starts.
        others: ``{name of another workcell: {dotted key: value}}``, its changes of the scene.
        base: The setting at which the workcells are compared.
        seeds: Seeds, the same in all workcells.
        draws: Draws of the noise for each seed.
    """

    def means(scene: Mapping[str, Any]) -> Array:
        ensemble = build_ensemble(scene, base_dir, seeds, draws, [base], (), 0)
        return np.array([ensemble.log_errors(base, sizes).mean(axis=0) for sizes in _ONE_EFFECT])

    own = means(config)
    differences = {name: means(with_overrides(config, changes)) - own for name, changes in others.items()}
    rows = np.array([d.ravel() for d in differences.values()]).reshape(-1, own.size)
    moment = rows.T @ rows / max(len(rows), 1) + _LEAST_VARIANCE * np.eye(own.size)
    return moment, {name: [float(x) for x in d.mean(axis=0)] for name, d in differences.items()}
