"""Residuals as a person pictures them: a height over a plate, a scan's shift, a range's error; in metres,
with a sign."""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.profiles import Axis, Map, Profile, View, variable_axis
from scalar.effects.effect import PointEffect
from scalar.effects.sensor import RangeDistortion
from scalar.effects.surface import PlaneBow, PlaneMoved
from scalar.estimation.residuals import BoundPointEffect
from scalar.geometry.se3 import Array
from scalar.sensors import Pieces
from scalar.sensors.scan_pieces import PIECES


def signed_residual(state: FittedState) -> Array:
    """Return each pose's residual ``(N,)`` [m], as its kind of sensor shows it: a height over the plane, or a distance without a sign."""
    rows = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    residual = state.residuals.residual(state.model)[:rows]
    return state.residuals.measurement.shown_residual(residual.reshape(state.dataset.n_poses, -1))


def pieces(state: FittedState, effect: PointEffect) -> Pieces:
    """Return the scans in pieces, or a probe's contacts, with what one effect adds."""
    residuals = state.residuals
    return residuals.measurement.pieces(
        residuals.kinematics(state.model).T_base_sensor,
        state.model.target,
        residuals.point_effects(state.model),
        BoundPointEffect(effect, residuals.poses),
    )


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
