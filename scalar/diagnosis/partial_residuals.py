"""What each pose asks of an effect: the numbers behind the report's pictures.

At the fitted model a pose's whitened rows r and their derivative g by one number of the effect (a joint's
angle, the growth, a plate's height) give what the pose asks for beside what is modelled, ``-g . r / g . g``,
with the standard error ``1 / |g|``. Added to what the effect says at that pose it is the partial residual:
the error as it stands when the effect alone is taken away.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.data.poses import Poses, is_joint
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.profiles import Axis, Map, Profile, View, angle_axis, variable_axis
from scalar.diagnosis.scan_residuals import moved_plate, over_plate, over_range
from scalar.effects.base import BaseCompliance
from scalar.effects.effect import JointEffect
from scalar.effects.joints import JointBacklash, JointCompliance, JointCoupling, JointHarmonic, JointScale
from scalar.effects.links import ThermalDrift
from scalar.effects.sensor import RangeDistortion, RangeOffset, RangeScale, SensorSlip
from scalar.effects.surface import PlaneBow, PlaneMoved
from scalar.effects.unattributed import UnattributedJoint
from scalar.geometry.screws import change_frame
from scalar.geometry.se3 import Array

CURVE_POINTS = 361
HIGH_ORDER = (
    5  # from here on a gear's curve is hard to follow along the whole joint, and is shown folded as well
)


def profiles(view: View, index: int) -> list[Profile | Map]:
    """Return what the poses ask of effect ``index`` of a state: at least one course or map."""
    effect = view.state.effects[index]
    if isinstance(effect, JointCompliance):
        return [_under_torque(view, effect, joint) for joint in effect.target["joints"]]
    if isinstance(effect, JointHarmonic):
        return _gear(view, effect)
    if isinstance(effect, JointScale):
        return [_along_joint(view, effect, effect.joint, effect.joint)]
    if isinstance(effect, JointCoupling):
        return [_along_joint(view, effect, effect.joint, effect.source)]
    if isinstance(effect, JointBacklash):
        return [_play(view, effect)]
    if isinstance(effect, UnattributedJoint):
        return [_flexible(view, effect)]
    if isinstance(effect, ThermalDrift):
        return [_growth(view, effect)]
    if isinstance(effect, BaseCompliance):
        return [_tilt(view, effect)]
    if isinstance(effect, SensorSlip):
        return [_slip(view, effect)]
    if isinstance(effect, (RangeScale, RangeOffset, RangeDistortion)):
        return [over_range(view, effect)]
    if isinstance(effect, PlaneBow):
        return [over_plate(view, effect)]
    if isinstance(effect, PlaneMoved):
        return [moved_plate(view, effect)]
    return [beside_everything(view, index)]


def _joint_screw(view: View, joint: int) -> Array:
    n = view.state.model.robot.n_joints
    return view.kinematics.screws()[:, :, 3 * n + joint - 1]


def _joint_course(
    view: View, effect: JointEffect, joint: int, x_axis: Axis, x: Array, **more: Any
) -> Profile:
    fitted = (effect.joint_basis(view.state.model.nominal, view.poses) @ effect.coefficients)[:, joint - 1]
    rest, std = view.asked(_joint_screw(view, joint))
    return Profile(
        x_axis, Axis(f"error of joint {joint}", "rad"), x, fitted + rest, rest, std, fitted, **more
    )


def _joint_curve(view: View, effect: JointEffect, joint: int, x: Array, poses: Poses) -> Array:
    basis = effect.joint_basis(view.state.model.nominal, poses)[:, joint - 1]
    return np.stack([x, basis @ effect.coefficients, view.error_of(effect, basis)])


def _sweep(view: View, joint: int) -> tuple[Array, Poses]:
    """Return a grid of one joint's angles as far as seen, and poses that have it, all else zero."""
    seen = view.poses.q[:, joint - 1]
    x = np.linspace(seen.min(), seen.max(), CURVE_POINTS)
    q = np.zeros((len(x), view.poses.q.shape[1]))
    q[:, joint - 1] = x
    return x, Poses(q, np.zeros(len(x)), {})


def _along_joint(view: View, effect: JointEffect, joint: int, source: int) -> Profile:
    x, grid = _sweep(view, source)
    curve = _joint_curve(view, effect, joint, x, grid)
    return _joint_course(view, effect, joint, angle_axis(source), view.poses.q[:, source - 1], curve=curve)


def _gear(view: View, effect: JointHarmonic) -> list[Profile | Map]:
    whole = _along_joint(view, effect, effect.joint, effect.joint)
    sizes = np.hypot(effect.coefficients[0::2], effect.coefficients[1::2])
    strongest = int(np.argmax(sizes))
    order = effect.orders[strongest]
    if order < HIGH_ORDER:
        return [whole]
    own = slice(2 * strongest, 2 * strongest + 2)
    one = JointHarmonic(effect.joint, (order,), coefficients=effect.coefficients[own])
    period = 2 * np.pi / order
    x = np.linspace(0.0, period, CURVE_POINTS)
    q = np.zeros((len(x), view.poses.q.shape[1]))
    q[:, effect.joint - 1] = x
    basis = one.joint_basis(view.state.model.nominal, Poses(q, np.zeros(len(x)), {}))[:, effect.joint - 1]
    padded = np.zeros((len(x), len(effect.coefficients)))
    padded[:, own] = basis
    curve = np.stack([x, basis @ one.coefficients, view.error_of(effect, padded)])
    axis = Axis(f"angle of joint {effect.joint} within a period of order {order}", "rad")
    folded = np.mod(view.poses.q[:, effect.joint - 1], period)
    note = f"Order {order} alone, all its periods laid over one another."
    return [whole, _joint_course(view, one, effect.joint, axis, folded, curve=curve, note=note)]


def _under_torque(view: View, effect: JointCompliance, joint: int) -> Profile:
    fitted = (effect.joint_basis(view.state.model.nominal, view.poses) @ effect.coefficients)[:, joint - 1]
    largest = max(float(np.max(np.abs(fitted))), 1e-300)
    # Torque and deflection are the same function but for the stiffness, which is not known apart.
    axis = Axis(f"gravity torque on joint {joint}, share of its largest", "1")
    ends = np.array([float(fitted.min()), float(fitted.max())])
    curve = np.stack([ends / largest, ends, np.zeros(2)])
    note = "The torque's shape is fitted too, since the masses of the links are not known."
    return _joint_course(view, effect, joint, axis, fitted / largest, curve=curve, note=note)


def _play(view: View, effect: JointBacklash) -> Profile:
    j = effect.joint
    if effect.by == "approach":
        side = np.sign(view.poses.column(f"approach{j}"))
        return _joint_course(view, effect, j, angle_axis(j), view.poses.q[:, j - 1], side=side)
    torque = effect.torque(view.state.model.nominal, view.poses.q)
    x = torque / max(float(np.max(np.abs(torque))), 1e-300)
    axis = Axis(f"gravity torque on joint {j}, share of its largest", "1")
    return _joint_course(view, effect, j, axis, x, side=np.sign(torque))


def _flexible(view: View, effect: UnattributedJoint) -> Profile | Map:
    first = effect.variables[0]
    if len(effect.variables) == 1:
        values = first.values(view.poses)
        x = np.linspace(first.centre - first.half, first.centre + first.half, CURVE_POINTS)
        q = np.zeros((len(x), view.poses.q.shape[1]))
        if is_joint(first.name):
            q[:, int(first.name[1:]) - 1] = x
        curve = _joint_curve(view, effect, effect.joint, x, Poses(q, x, {first.name: x}))
        return _joint_course(view, effect, effect.joint, variable_axis(first.name), values, curve=curve)
    second = effect.variables[1]
    course = _joint_course(view, effect, effect.joint, variable_axis(first.name), first.values(view.poses))
    good = course.std < 3.0 * np.nanmedian(course.std)
    u, v = course.x[good], second.values(view.poses)[good]
    y, rest = course.y[good], course.rest[good]
    return Map(course.x_axis, variable_axis(second.name), course.y_axis, u, v, y, rest, np.flatnonzero(good))


def _growth(view: View, effect: ThermalDrift) -> Profile:
    nominal, poses = view.state.model.nominal, view.poses
    driver = poses.order if effect.by == "order" else poses.column(effect.by)
    screws = view.kinematics.screws()[:, :, : nominal.geometry.size]
    # A growth of one: the lengths themselves.
    unit = ThermalDrift("order", 0.0).geometry_basis(nominal, Poses(poses.q[:1], np.ones(1), {}))
    lengths = unit.reshape(nominal.geometry.size)
    rest, std = view.asked(screws @ lengths)

    def course_of(x: Array) -> Array:
        shifted = np.asarray(x, dtype=float) - effect.reference
        if effect.time_constant:
            shifted = 1.0 - np.exp(-np.maximum(shifted, 0.0) / effect.time_constant)
        return shifted

    x = np.linspace(driver.min(), driver.max(), CURVE_POINTS)
    basis = course_of(x)[:, None]
    curve = np.stack([x, basis @ effect.coefficients, view.error_of(effect, basis)])
    fitted = course_of(driver) * effect.coefficients[0]
    axis = Axis("growth of all lengths", "m/m")
    return Profile(variable_axis(effect.by), axis, driver, fitted + rest, rest, std, fitted, curve)


def _tilt(view: View, effect: BaseCompliance) -> Profile:
    w = effect.base_screws(view.state.model.nominal, view.poses) @ effect.coefficients
    size = np.linalg.norm(w[:, :3], axis=1)
    largest = max(float(size.max()), 1e-300)
    rest, std = view.asked(w / np.maximum(size, 1e-300)[:, None])
    curve = np.array([[0.0, 1.0], [0.0, largest], [0.0, 0.0]])
    x_axis, y_axis = Axis("overturning moment, share of its largest", "1"), Axis("tilt of the base", "rad")
    note = "The moment's shape is fitted too, since the masses of the links are not known."
    return Profile(x_axis, y_axis, size / largest, size + rest, rest, std, size, curve, note=note)


def _slip(view: View, effect: SensorSlip) -> Profile:
    order = view.poses.order
    after = order >= effect.order
    t = effect.coefficients[:3]
    shift = float(np.linalg.norm(t))
    motion = np.zeros(6)
    motion[3:] = t
    if effect.turns:
        motion[:3] = effect.coefficients[3:]
    repeated = np.broadcast_to(motion[:, None], (len(order), 6, 1))
    screws = change_frame(view.kinematics.T_base_sensor, repeated)[:, :, 0]
    size = max(shift, 1e-300)
    rest, std = view.asked(screws / size)
    fitted = np.where(after, shift, 0.0)
    at = np.array([order.min(), effect.order, effect.order, order.max()])
    curve = np.stack([at, np.array([0.0, 0.0, shift, shift]), np.zeros(4)])
    y_axis = Axis("slip of the sensor along the fitted motion", "m")
    note = "Where the sensor turned as well, the turn goes along in proportion." if effect.turns else ""
    x_axis, mark = variable_axis("order"), effect.order
    return Profile(x_axis, y_axis, order, fitted + rest, rest, std, fitted, curve, mark=mark, note=note)


def beside_everything(view: View, index: int) -> Profile:
    """Return what is measured against what an effect predicts, without what all other parameters would
    take up.

    For effects that are no function of any one variable: the added-variable plot, its slope one where the
    effect explains the residual.
    """
    N, m = view.residual.shape
    jacobian = view.state.linearised()[1]
    mine, coefficients = _free_part(view.state, index)
    J = jacobian[:, ~mine]
    lengths = np.linalg.norm(J, axis=0)
    Q = np.linalg.qr(J[:, lengths > 0] / lengths[lengths > 0])[0]
    signal = jacobian[:, mine] @ coefficients
    left = (signal - Q @ (Q.T @ signal))[: N * m].reshape(N, m)
    x, rest, std = view.state.residuals.measurement.shift(left, view.residual)
    ends = np.array([float(x.min()), float(x.max())])
    curve = np.stack([ends, ends, np.zeros(2)])
    note = "What the other parameters would take up is removed from both."
    x_axis, y_axis = Axis("shift that the effect predicts", "m"), Axis("shift that is measured", "m")
    return Profile(x_axis, y_axis, x, x - rest, -rest, std, x, curve, note=note)


def seen_share(view: View, index: int) -> float:
    """Return how much of an effect's fitted signal no other parameter can take up, 0 to 1.

    With G the Gram matrix of all free columns, what is left of the effect's own beside the others is the
    Schur complement ``S = G_ee - G_eo G_oo^+ G_oe``, and the share ``sqrt(c' S c / c' G_ee c)``.
    """
    mine, c = _free_part(view.state, index)
    scale = np.sqrt(np.maximum(np.diag(view.gram), 1e-300))
    G = view.gram / np.outer(scale, scale)
    c = c * scale[mine]
    whole = float(c @ G[np.ix_(mine, mine)] @ c)
    across = G[np.ix_(~mine, mine)] @ c
    taken = float(across @ np.linalg.lstsq(G[np.ix_(~mine, ~mine)], across, rcond=1e-12)[0])
    return float(np.sqrt(np.clip((whole - taken) / whole, 0.0, 1.0))) if whole > 0 else 0.0


def _free_part(state: FittedState, index: int) -> tuple[Array, Array]:
    """Return which of the free columns are an effect's, and its coefficients that are free."""
    start = state.model.blocks["effects"].start + sum(len(e.coefficients) for e in state.effects[:index])
    own = np.zeros(len(state.free), dtype=bool)
    own[start : start + len(state.effects[index].coefficients)] = True
    return own[state.free], state.model.vector[own & state.free]
