"""The columns of an effect at given poses, refused by the effect's name where they have the wrong shape or are no numbers.

An effect may come from a file of a user's own, so a wrong shape is a fault of that file and not of this program.
"""

from __future__ import annotations

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import Effect
from scalar.effects.places import BaseEffect, JointEffect, LinkEffect, SensorEffect, SingleJointEffect
from scalar.errors import Fault, InvalidInput
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array


def checked_basis(effect: Effect, nominal: Robot, poses: Poses) -> Array | None:
    """Return the columns of an effect on one joint ``(N, k)``, on several ``(N, n, k)``, on links ``(N, 5, n, k)``, base or sensor ``(N, 6, k)``.

    None is returned for an effect on points.

    Raises:
        InvalidInput: The effect's method returns something else.
    """
    N, n, k = len(poses), nominal.n_joints, len(effect.coefficients)
    if isinstance(effect, SingleJointEffect):
        method, shape, axes = effect.own_columns, (N, k), "poses, coefficients"
    elif isinstance(effect, JointEffect):
        method, shape, axes = effect.joint_basis, (N, n, k), "poses, joints, coefficients"
    elif isinstance(effect, LinkEffect):
        method, shape, axes = effect.geometry_basis, (N, 5, n, k), "poses, parameters, joints, coefficients"
    elif isinstance(effect, BaseEffect):
        method, shape, axes = effect.base_screws, (N, 6, k), "poses, components, coefficients"
    elif isinstance(effect, SensorEffect):
        method, shape, axes = effect.sensor_screws, (N, 6, k), "poses, components, coefficients"
    else:
        return None
    if not N:  # an effect, which may be a user's own, need not cope with no poses at all
        return np.zeros(shape)
    basis = method(nominal, poses)
    if np.shape(basis) != shape:
        found = f"has the shape {np.shape(basis)} and not {shape}: {axes}"
    elif not np.isfinite(basis).all():
        found = "holds numbers that are not finite"
    else:
        return basis
    raise InvalidInput(Fault(f"effect '{effect.name}'", f"what {method.__name__} returns {found}"))
