"""Tabulate the error of each joint's gear over its angle, and how far two campaigns agree on it.

Angles a full turn apart are the same angle of the gear. An angle counts as measured (``seen``) only if a campaign has poses nearby.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.poses import Poses
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.result import Calibration
from scalar.geometry.se3 import Array
from scalar.units import DEG, MRAD

STEP_DEG = 2.0
NEAR = 3  # least number of poses within 1.5 steps of an angle with which it counts as measured
COLUMNS = ("joint", "angle_deg", "error_mrad", "std_mrad", "seen")


def gear_errors(found: Calibration, dataset: Dataset) -> pd.DataFrame:
    """Return the periodic error of every joint that has one: a row for each joint and angle.

    Columns: joint (from 1), angle_deg (-180 to 180), error_mrad and std_mrad (of the error, all else being estimated as well), seen
    (whether poses of the dataset stand nearby).
    """
    angles = np.arange(-180.0, 180.0, STEP_DEG)
    tables = []
    joints = sorted({e.joint for e in found.model.effects if isinstance(e, JointHarmonic)})
    for joint in joints:
        error, variance = _error(found, joint, angles * DEG)
        tables.append(
            pd.DataFrame(
                {
                    "joint": joint,
                    "angle_deg": angles,
                    "error_mrad": error / MRAD,
                    "std_mrad": np.sqrt(variance) / MRAD,
                    "seen": _seen(dataset.q[:, joint - 1] / DEG, angles),
                }
            )
        )
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(COLUMNS))


def _error(found: Calibration, joint: int, angles: Array) -> tuple[Array, Array]:
    """Return the error ``(N,)`` [rad] of a joint's gear and its variance ``(N,)`` [rad^2] at angles ``(N,)`` [rad]."""
    model = found.model
    q = np.zeros((len(angles), model.robot.n_joints))
    q[:, joint - 1] = angles
    at = Poses(q, np.zeros(len(angles)), {})
    place = {name: i for i, name in enumerate(found.free)}
    error = np.zeros(len(angles))
    columns, where = [], []
    for effect, names in zip(model.effects, model.effect_names, strict=True):
        if isinstance(effect, JointHarmonic) and effect.joint == joint:
            basis = effect.joint_basis(model.nominal, at)[:, joint - 1]
            error += basis @ effect.coefficients
            known = [k for k, name in enumerate(names) if name in place]
            columns.append(basis[:, known])
            where += [place[names[k]] for k in known]
    basis = np.concatenate(columns, axis=1)
    covariance = found.covariance[np.ix_(where, where)]
    return error, np.maximum(np.einsum("ni,ij,nj->n", basis, covariance, basis), 0.0)


def _seen(poses_deg: Array, angles_deg: Array) -> Array:
    """Return whether at least ``NEAR`` poses lie within 1.5 steps of each angle, modulo full turns."""
    apart = np.abs((poses_deg[:, None] - angles_deg + 180.0) % 360.0 - 180.0)
    return np.sum(apart <= 1.5 * STEP_DEG, axis=0) >= NEAR


def agreement(one: pd.DataFrame, other: pd.DataFrame) -> list[dict[str, Any]]:
    """Return for every joint how far two campaigns agree on its error, at the angles that both have measured.

    A straight line is first subtracted from each curve, since data over a part of a turn do not distinguish it from the arm's geometry.

    Args:
        one: The gear errors of one campaign, as `gear_errors` returns them.
        other: Those of the other campaign.

    Returns:
        For each joint: ``joint``; ``both_seen_deg``, the range of angles that both measured; ``correlation`` of the two curves; and the root mean
        squares of each curve and of their difference, ``one_rms_mrad``, ``other_rms_mrad`` and ``apart_rms_mrad``.
    """
    return list(_agreements(one, other))


def _agreements(one: pd.DataFrame, other: pd.DataFrame) -> Iterator[dict[str, Any]]:
    both: Any = one.merge(other, on=["joint", "angle_deg"], suffixes=("", "_other"))
    both = both[both["seen"] & both["seen_other"]]
    groups: Any = both.groupby("joint")
    for joint, rows in groups:
        if len(rows) < 5:
            continue
        x = rows["angle_deg"].to_numpy()
        a, b = (_without_line(x, rows[name].to_numpy()) for name in ("error_mrad", "error_mrad_other"))
        yield {
            "joint": int(joint),
            "both_seen_deg": float(STEP_DEG * len(rows)),
            "correlation": float(np.corrcoef(a, b)[0, 1]),
            "one_rms_mrad": float(np.sqrt(np.mean(a**2))),
            "other_rms_mrad": float(np.sqrt(np.mean(b**2))),
            "apart_rms_mrad": float(np.sqrt(np.mean((a - b) ** 2))),
        }


def _without_line(x: Array, y: Array) -> Array:
    """Return values ``y`` without the straight line over ``x`` that fits them best."""
    return y - np.polyval(np.polyfit(x, y, 1), x)
