"""All lengths of an arm that grow alike: the columns and the picture that effects of heat share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import Effect
from scalar.effects.picture import CURVE_POINTS, Axis, Profile, View, variable_axis
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array


def time_constant_steps(scale: float) -> list[float]:
    """Return the factors by which a time constant is varied when it is refined, in steps of ``scale`` (``Effect.variations``)."""
    return [3.0 ** (a * scale) for a in (-0.5, -0.25, 0.0, 0.25, 0.5)]


def growing_lengths(robot: Robot, poses: Poses, profile: Array) -> Array:
    """Return the nominal lengths at each pose, times the profiles ``(N, k)`` of their growth: ``(N, 5, n, k)`` [m]."""
    lengths = np.array([kind in LENGTHS for kind in GEOMETRY])[:, None] * robot.geometry
    lengths = np.broadcast_to(lengths, (len(poses), *lengths.shape)).copy()
    travel = list(robot.prismatic)  # a rack or a screw grows as the links do
    lengths[:, GEOMETRY.index("d"), travel] += poses.q[:, travel]
    return profile[:, None, None, :] * lengths[..., None]


def growth_picture(
    view: View, effect: Effect, by: str, driver: Array, growth: Callable[[Array], Array]
) -> Profile:
    """Return the growth of all lengths over what drives it.

    Args:
        view: The fitted model.
        effect: The growth, with its coefficients.
        by: The column that drives it.
        driver: ``(N,)``, its values at the poses.
        growth: Gives the profiles ``(G, k)`` at values ``(G,)`` of that column.
    """
    nominal = view.nominal
    lengths = np.array([kind in LENGTHS for kind in GEOMETRY])[:, None] * nominal.geometry
    rest, std = view.estimated_along(view.geometry_screws() @ lengths.ravel())
    x = np.linspace(driver.min(), driver.max(), CURVE_POINTS)
    basis = growth(x)
    curve = np.stack([x, basis @ effect.coefficients, view.error_of(effect, basis)])
    fitted = growth(driver) @ effect.coefficients
    axis = Axis("growth of all lengths", "m/m")
    return Profile(variable_axis(by, nominal), axis, driver, fitted + rest, rest, std, fitted, curve)
