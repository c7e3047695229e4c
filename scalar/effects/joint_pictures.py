"""Pictures of errors of one joint's angle: the error that each pose shows, over the variable that drives it."""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.picture import CURVE_POINTS, Axis, Profile, View, joint_axis
from scalar.geometry.se3 import Array


def along_joint(view: View, effect: Any, joint: int, source: int) -> Profile:
    """Return the error of a joint over the angle of the joint ``source`` on which it depends; both count from 1."""
    x, grid = _sweep(view, source)
    curve = joint_curve(view, effect, joint, x, grid)
    return joint_profile(
        view, effect, joint, joint_axis(view.nominal, source), view.poses.q[:, source - 1], curve=curve
    )


def joint_profile(view: View, effect: Any, joint: int, x_axis: Axis, x: Array, **more: Any) -> Profile:
    """Return the error of a joint over any variable ``(N,)``.

    Args:
        view: The fitted model.
        effect: The effect on the joint.
        joint: From 1.
        x_axis, x: The variable, and its value at each pose ``(N,)``.
        more: Further fields of the profile.
    """
    fitted = (effect.joint_basis(view.nominal, view.poses) @ effect.coefficients)[:, joint - 1]
    rest, std = view.estimated_along(view.joint_screws(joint))
    y_axis = Axis(f"error of joint {joint}", effect.joint_unit)
    return Profile(x_axis, y_axis, x, fitted + rest, rest, std, fitted, **more)


def joint_curve(view: View, effect: Any, joint: int, x: Array, poses: Poses) -> Array:
    """Return the fitted curve ``(3, G)`` of a joint's error: x, the error [rad, or m of a joint that slides] and its standard error.

    Args:
        view: The fitted model that is drawn.
        effect: The effect of the joint.
        joint: The joint, from 1.
        x: ``(G,)``, values on the horizontal axis.
        poses: The G poses at which the horizontal axis has these values.
    """
    basis = effect.joint_basis(view.nominal, poses)[:, joint - 1]
    return np.stack([x, basis @ effect.coefficients, view.error_of(effect, basis)])


def _sweep(view: View, joint: int) -> tuple[Array, Poses]:
    """Return a grid over the measured range of one joint's angle, and poses on that grid with all other angles zero."""
    measured = view.poses.q[:, joint - 1]
    x = np.linspace(measured.min(), measured.max(), CURVE_POINTS)
    return x, at_angle(x, joint, view.poses.q.shape[1])


def at_angle(x: Array, joint: int, n_joints: int) -> Poses:
    """Return poses with one joint at angles ``(G,)`` [rad] and all others at zero."""
    q = np.zeros((len(x), n_joints))
    q[:, joint - 1] = x
    return Poses(q, np.zeros(len(x)), {})
