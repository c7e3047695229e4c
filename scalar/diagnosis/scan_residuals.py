"""Residuals as a person pictures them: a height over a plate, a scan's shift, a range's error; in metres,
with a sign."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.profiles import Axis, Map, Profile, View, variable_axis
from scalar.effects.effect import PointEffect
from scalar.effects.sensor import RangeDistortion
from scalar.effects.surface import PlaneBow, PlaneMoved
from scalar.geometry.se3 import Array
from scalar.sensors.line_laser import LineLaser, contact, point_basis
from scalar.sensors.tracker import Tracker

PIECES = 4  # that each scan is averaged in: its ends and its middle tell a bent plate from a turned one


def shift_of_poses(state: FittedState, predicted: Array, residual: Array) -> tuple[Array, Array, Array]:
    """Return each pose's shift by a prediction and by the residual [m], with the standard error, ``(N,)``
    each.

    A scan's shift is the mean height of its points over the plate; a tracked point's is along the prediction.

    Args:
        state: Gives the weights.
        predicted, residual: ``(N, m)``, whitened rows.
    """
    measurement = state.residuals.measurement
    if isinstance(measurement, LineLaser):
        length = 1.0 / measurement.R[:, 0, 0]
        return predicted[:, 0] * length, residual[:, 0] * length, np.abs(length)
    if isinstance(measurement, Tracker):
        size = np.linalg.norm(predicted, axis=1)
        along = predicted / np.maximum(size, 1e-300)[:, None]
        sigma = np.full(len(size), measurement.sigma)
        return size * sigma, np.sum(along * residual, axis=1) * sigma, sigma
    sigma = np.full(len(residual), measurement.sigma)
    return predicted[:, 0] * sigma, residual[:, 0] * sigma, sigma


def signed_residual(state: FittedState) -> Array:
    """Return each pose's residual ``(N,)`` [m]: height over the plate; for a tracker the distance,
    without a sign."""
    rows = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    residual = state.residuals.residual(state.model)[:rows]
    residual = residual.reshape(state.dataset.n_poses, -1)
    if isinstance(state.residuals.measurement, Tracker):
        return np.linalg.norm(residual, axis=1) * state.residuals.measurement.sigma
    return shift_of_poses(state, residual, residual)[1]


@dataclass(frozen=True, eq=False)
class Pieces:
    """Scans cut in a few pieces each, averaged. P pieces.

    Attributes:
        pose: ``(P,)``, which pose.
        reach: ``(P,)`` [m], measured range, or z.
        position: ``(P, 3)`` [m], base frame.
        height: ``(P,)`` [m], over the plate as all effects have it.
        of_effect: ``(P,)`` [m], what the effect in question adds to the height.
        incidence: ``(P,)``, ``n . e``: by how much the height grows with the range.
        std: ``(P,)`` [m], standard error of the height.
    """

    pose: Array
    reach: Array
    position: Array
    height: Array
    of_effect: Array
    incidence: Array
    std: Array


def pieces(state: FittedState, effect: PointEffect) -> Pieces:
    """Return the scans in pieces, or a probe's contacts, with what one effect adds."""
    measurement: Any = state.residuals.measurement
    planes: Any = state.model.target
    T = state.residuals.kinematics(state.model).T_base_sensor
    index = measurement.target_index
    if not isinstance(measurement, LineLaser):
        return _contacts(state, effect, T)
    points, starts, axis = measurement.points, measurement.starts, measurement.error_axis
    counts = np.diff(starts)
    scan = np.repeat(np.arange(len(counts)), counts)
    c = contact(T, planes, index)[0]
    flat = np.sum(point_basis(("1", "x", "z"), points, axis) * c[scan], axis=1)

    def added(other: PointEffect) -> Array:
        G = other.contact_columns(state.residuals.poses, T, planes, index, c) @ other.coefficients
        return np.sum(point_basis(other.basis_names, points, axis) * G[scan], axis=1)

    height = flat + sum((added(e) for e in state.effects if isinstance(e, PointEffect)), np.zeros(len(flat)))
    ux, uz = point_basis(("ux", "uz"), points, axis).T
    incidence = c[scan, 1] * ux + c[scan, 2] * uz
    reach = np.hypot(points[:, 0], points[:, 1]) if axis == "ray" else points[:, 1]
    position = T[scan, :3, 3] + T[scan, :3, 0] * points[:, :1] + T[scan, :3, 2] * points[:, 1:]
    rank = np.arange(len(points)) - starts[scan]
    group = scan * PIECES + rank * PIECES // np.maximum(counts[scan], 1)
    found, where, size = np.unique(group, return_inverse=True, return_counts=True)

    def mean(values: Array) -> Array:
        return np.bincount(where, values, len(found)) / size

    std = measurement.sigma * np.abs(mean(incidence)) / np.sqrt(size)
    place = np.stack([mean(position[:, i]) for i in range(3)], axis=1)
    return Pieces(
        found // PIECES, mean(reach), place, mean(height), mean(added(effect)), mean(incidence), std
    )


def _contacts(state: FittedState, effect: PointEffect, T: Array) -> Pieces:
    measurement, planes = state.residuals.measurement, state.model.target
    N = len(T)
    whitened = measurement.rows(T, planes, state.residuals.point_effects(state.model)).residual[:, 0]
    rows = whitened * measurement.sigma
    at = np.zeros((N, 1))
    G = effect.contact_columns(state.residuals.poses, T, planes, measurement.target_index, at)[:, 0]
    sigma = np.full(N, measurement.sigma)
    return Pieces(np.arange(N), np.zeros(N), T[:, :3, 3], rows, G @ effect.coefficients, np.ones(N), sigma)


def _on_plate(state: FittedState, plane: str, pose: Array) -> Array:
    wanted = next(k for k, guess in enumerate(state.dataset.planes) if guess.name == plane)
    return state.dataset.plane_index[pose] == wanted


def over_plate(view: View, effect: PlaneBow) -> Map:
    """Return the heights of a plate's points over its plane, in the two base axes nearest to it."""
    state = view.state
    found = pieces(state, effect)
    mine = _on_plate(state, effect.plane, found.pose)
    position, height = found.position[mine], found.height[mine]
    planes: Any = state.model.target
    names = list(planes.names)
    k = next(i for i, name in enumerate(names) if name.split("@")[0] == effect.plane or name == effect.plane)
    across = int(np.argmax(np.abs(planes.normals[k])))
    a, b = [i for i in range(3) if i != across]
    u_axis, v_axis = (Axis(f"{'xyz'[i]} of the base", "m") for i in (a, b))
    y_axis = Axis("height over the plane", "m")
    without = height - found.of_effect[mine]
    note = f"Each scan is cut in {PIECES} pieces." if len(found.pose) > view.state.dataset.n_poses else ""
    pose = found.pose[mine]
    return Map(u_axis, v_axis, y_axis, position[:, a], position[:, b], without, height, pose, note)


def moved_plate(view: View, effect: PlaneMoved) -> Profile:
    """Return the heights of a plate's scans over the plane where it stood first, in order of acquisition."""
    state = view.state
    found = pieces(state, effect)
    mine = _on_plate(state, effect.plane, found.pose)
    pose, n = found.pose[mine], np.maximum(np.bincount(found.pose[mine], minlength=state.dataset.n_poses), 1)

    def mean(values: Array) -> Array:
        return (np.bincount(pose, values[mine], state.dataset.n_poses) / n)[touched]

    touched = np.unique(pose)
    rest, fitted = mean(found.height), -mean(found.of_effect)
    std = np.sqrt(mean(found.std**2) / n[touched])
    order = view.poses.order[touched]
    axis = Axis("height over the plane as it stood first", "m")
    note = "A tilted plate rises at some poses and falls at others." if effect.coefficients[1:].any() else ""
    x_axis, mark = variable_axis("order"), effect.order
    return Profile(x_axis, axis, order, fitted + rest, rest, std, fitted, mark=mark, pose=touched, note=note)


def over_range(view: View, effect: PointEffect) -> Profile:
    """Return what has to be added to the measured range, against the range."""
    found = pieces(view.state, effect)
    steep = np.abs(found.incidence) > 0.05
    reach, incidence, pose = found.reach[steep], found.incidence[steep], found.pose[steep]
    rest, fitted = -found.height[steep] / incidence, found.of_effect[steep] / incidence
    names = effect.coefficient_names
    x = np.linspace(reach.min(), reach.max(), 61)
    middle = effect.middle if isinstance(effect, RangeDistortion) else 0.0
    powers = {"curvature_per_m": (x - middle) ** 2, "gain_m_per_m": x, "offset_m": np.ones_like(x)}
    basis = np.stack([powers[name] for name in names], axis=1)
    curve = np.stack([x, basis @ effect.coefficients, view.error_of(effect, basis)])
    std = found.std[steep] / np.abs(incidence)
    note = f"Each scan is cut in {PIECES} pieces."
    if isinstance(effect, RangeDistortion):
        # Gain and zero hide in the geometry nearly whole: only what departs from a straight line is news.
        line = np.polynomial.Polynomial.fit(reach, fitted, 1)
        gauge = np.column_stack([np.ones_like(x), x])
        hat = gauge @ np.linalg.lstsq(gauge, basis, rcond=None)[0]
        curve = np.stack([x, curve[1] - line(x), view.error_of(effect, basis - hat)])
        fitted = fitted - line(reach)
        note += " A straight line is taken off: gain and zero cannot be told from the geometry."
    x_axis, y_axis = Axis("measured range", "m"), Axis("correction of the range", "m")
    return Profile(x_axis, y_axis, reach, fitted + rest, rest, std, fitted, curve, pose=pose, note=note)
