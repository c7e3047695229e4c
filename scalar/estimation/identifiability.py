"""Which directions of the model no measurement of this kind can see, and the smallest set of parameters to hold because of them.

The Jacobian is taken for *perfect* measurements, which satisfy the model exactly, so that a direction that leaves the residual
alone has a singular value of rounding size, whatever the noise. Axes within a few degrees of parallel are taken as parallel: beside
such a pair plain DH can trade d of one joint against d of the next with almost no residual, and the fit would run away along it.

Directions are *structural* (no poses whatever would show them: the base, the flange, scale) or due to *these poses* (a joint that
never moves). Singular values as in Hollerbach and Wampler (1996); the choice of what to hold is rank-revealing, QR with column pivoting
on the null space (Golub and Van Loan, 5.4), and prefers the base and the flange, whose places are conventions, where they serve as well.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import qr

from scalar.data.poses import Poses
from scalar.estimation.model import Anchor, EffectBases, Kinematics, Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.se3 import Array
from scalar.sensors import Measurement
from scalar.sensors.line_laser import LineLaser
from scalar.units import DEG, MM

NEAR_PARALLEL = 0.1  # rad, 6 degrees: closer than that two axes are taken as parallel
NULL_TOLERANCE = 1e-8  # of the largest singular value, columns scaled to unit length
STRUCTURAL_POSES_PER_TARGET = 40
STILL = 2e-3  # rad, a tenth of a degree: a joint that moves less than this is held still (a loaded brake gives a little)
_ZERO_COLUMN = 1e-12  # of the largest column: a parameter that no residual depends on
_SPAN_TOLERANCE = 0.05  # what a parameter must add to those already held to be worth holding
_CONDITION_SLACK = 30.0  # how much worse than the rank-revealing set the preferred one may be
_STRUCTURAL = 1e-5  # of a direction of unit length: less of it outside the structural null space is rounding
_WORTH_NAMING = 0.02  # of the largest component: below it a parameter is not named in a direction


@dataclass(frozen=True)
class Held:
    """A parameter that is held, and why.

    Attributes:
        name: Of the parameter.
        reason: A sentence.
        moves_with: Names of the parameters that would take up a change of it.
        cause: ``structural``: no poses whatever would free it; ``still``: a joint that never moves hides it; ``poses``: others would.
    """

    name: str
    reason: str
    moves_with: tuple[str, ...]
    cause: str


@dataclass(frozen=True, eq=False)
class Identifiability:
    """What the singular value decomposition says of a model and its poses.

    Attributes:
        names: ``(C,)``, the candidates: parameters that would be free if they could be seen.
        singular_values: ``(C,)``, of the column-scaled Jacobian at the poses, descending, the largest being 1.
        null_directions: ``(r, C)``, one for each held parameter, in the parameters' own units, that parameter's component being 1.
        n_structural: How many of the null directions no poses would show.
        held: ``(r,)``, what to hold.
    """

    names: tuple[str, ...]
    singular_values: Array
    null_directions: Array
    n_structural: int
    held: tuple[Held, ...]

    @property
    def n_null(self) -> int:
        """Return the number of null directions at these poses."""
        return len(self.null_directions)

    @property
    def held_names(self) -> tuple[str, ...]:
        """Return the names of what to hold."""
        return tuple(held.name for held in self.held)

    def sentences(self) -> list[str]:
        """Return what is held and why, one sentence each."""
        return [f"{held.name} is held: {held.reason}." for held in self.held]


def analyse(residuals: Residuals, model: Model, candidates: Array) -> Identifiability:
    """Return which directions the poses of a dataset cannot show, and what to hold because of them.

    Args:
        residuals: Of the dataset.
        model: Where to look; its target should fit the data roughly. Its effects are left out.
        candidates: ``(P,)`` bool over robot, sensor and target: what would be free if it could be seen.
    """
    ideal = _with_parallel_axes(model)
    measurement, q = residuals.measurement, residuals.poses.q.copy()
    still = np.ptp(q, axis=0) < STILL
    q[:, still] = np.median(q[:, still], axis=0)
    J = _perfect_jacobian(residuals, measurement, ideal, q, measurement.target_index)[:, candidates]
    names = tuple(name for name, wanted in zip(ideal.names, candidates, strict=True) if wanted)
    scale, values, null = _null_space(J)
    q_any, index_any = _any_poses(ideal.robot, int(measurement.target_index.max()) + 1)
    J_any = _perfect_jacobian(residuals, measurement, ideal, q_any, index_any)[:, candidates]
    structural = _null_space_of_scaled(J_any / scale)[1]
    q_any[:, still] = q[:1, still]
    J_still = _perfect_jacobian(residuals, measurement, ideal, q_any, index_any)[:, candidates]
    hidden_by_still = _null_space_of_scaled(J_still / scale)[1]
    chosen = _choose(null, _preference(ideal.robot, names), J / scale)
    directions = np.zeros((0, len(names)))
    if chosen:
        directions = np.linalg.solve(null[chosen].T, null.T) / scale * scale[chosen][:, None]
    scaled = directions * scale
    scaled /= np.linalg.norm(scaled, axis=1, keepdims=True)
    cause = np.full(len(scaled), "poses", dtype=object)
    for name, space in (("still", hidden_by_still), ("structural", structural)):
        cause[np.linalg.norm(scaled - scaled @ space @ space.T, axis=1) < _STRUCTURAL] = name
    still_joints = [int(i) + 1 for i in np.flatnonzero(still)]
    values_at = dict(zip(ideal.names, ideal.vector, strict=True))
    held_names = {names[i] for i in chosen}
    own = [{k: v for k, v in values_at.items() if k == names[i] or k not in held_names} for i in chosen]
    held = tuple(
        _explain(names, index, direction, still_joints, values, str(why))
        for index, direction, values, why in zip(chosen, directions, own, cause, strict=True)
    )
    return Identifiability(names, values, directions, structural.shape[1], held)


def _with_parallel_axes(model: Model) -> Model:
    """Return the model without effects, near-parallel successive axes made exactly parallel."""
    geometry = model.robot.geometry.copy()
    alpha, beta = GEOMETRY.index("alpha"), GEOMETRY.index("beta")
    near = _near_parallel(model.robot)
    geometry[alpha] = np.where(near, np.pi * np.round(geometry[alpha] / np.pi), geometry[alpha])
    geometry[beta] = np.where(near, 0.0, geometry[beta])
    return replace(model, robot=model.robot.with_geometry(geometry), effects=()).rebased()


def _near_parallel(robot: Robot) -> Array:
    """Return for each joint whether its axis is near-parallel to the one before, ``(n,)`` bool; not so for the first."""
    near = np.abs(np.sin(robot.geometry[GEOMETRY.index("alpha")])) < NEAR_PARALLEL
    near[0] = False
    return near


def near_parallel_joints(robot: Robot) -> list[int]:
    """Return the joints, counted from 1, whose axis is near-parallel to the one before: where Hayati's beta belongs."""
    return [int(i) + 1 for i in np.flatnonzero(_near_parallel(robot))]


def _any_poses(robot: Robot, n_targets: int) -> tuple[Array, Array]:
    """Return joint angles all over the limits and targets for them: fixed, and the same for every dataset of a robot."""
    count = STRUCTURAL_POSES_PER_TARGET * n_targets
    unit = np.random.default_rng(0).random((count, robot.n_joints))
    return robot.limits[:, 0] + unit * np.ptp(robot.limits, axis=1), np.arange(count) % n_targets


def _perfect_jacobian(
    residuals: Residuals, measurement: Measurement, model: Model, q: Array, index: Array
) -> Array:
    """Return the Jacobian ``(rows, P)`` of measurements without error of targets ``index`` at joint angles q."""
    none = EffectBases([], [], [], [])

    def kinematics(q: Array) -> Kinematics:
        return Kinematics.of(model, Poses(q, np.arange(len(q), dtype=float), {}), none)

    at = kinematics(q)
    n = model.robot.n_joints
    moving = np.ptp(q, axis=0) > 0
    for _ in range(measurement.contact_iterations):
        by_angle = at.screws()[:, :, 3 * n : 4 * n]
        q = q + measurement.contact_step(at.T_base_sensor, model.target, index, by_angle * moving)
        at = kinematics(q)
    wrench, by_target, usable = measurement.perfect_rows(at.T_base_sensor, model.target, index)
    N, m, t = by_target.shape
    J = wrench @ at.screws()
    where = model.blocks["target"]
    items = np.zeros((N, m, (where.stop - where.start) // t, t))
    items[np.arange(N), :, index] = by_target
    J[:, :, where] = items.reshape(N, m, -1)
    J = J[usable].reshape(-1, J.shape[2])
    if residuals.known is None:
        return J
    known = residuals.known.rows(model.target)[1]  # type: ignore[arg-type]
    below = np.zeros((len(known), J.shape[1]))
    below[:, where] = known / np.abs(known).max()
    return np.vstack([J, below])


def _null_space(J: Array) -> tuple[Array, Array, Array]:
    """Return the column scales ``(C,)``, the scaled singular values ``(C,)`` and an orthonormal null space ``(C, r)``."""
    scale = np.linalg.norm(J, axis=0)
    dead = scale <= _ZERO_COLUMN * scale.max(initial=0.0)
    scale = np.where(dead, 1.0, scale)
    return scale, *_null_space_of_scaled(np.where(dead, 0.0, J / scale))


def _null_space_of_scaled(J: Array) -> tuple[Array, Array]:
    _, s, Vt = np.linalg.svd(np.linalg.qr(J, mode="r"), full_matrices=True)
    values = np.zeros(J.shape[1])
    values[: len(s)] = s / s[0]
    return values, Vt[values < NULL_TOLERANCE].T


def _preference(robot: Robot, names: tuple[str, ...]) -> list[int]:
    """Return the candidates in the order in which they would be held: what is convention or best known first.

    The base's parameters, the flange's, d of an axis that runs parallel to the next (the earlier), other lengths of the robot
    from the longest (scale), its angles, the sensor, and the target last.
    """
    n = robot.n_joints
    near = _near_parallel(robot)
    rank: dict[str, tuple[float, float]] = {}
    for i in range(n):
        for k, kind in enumerate(GEOMETRY):
            value = abs(float(robot.geometry[k, i]))
            if i == 0:
                key = (0.0, k)
            elif i == n - 1 and kind in ("d", "theta"):
                key = (1.0, k)
            elif kind == "d" and i + 1 < n and near[i + 1]:
                key = (2.0, i)
            elif kind in ("a", "d"):
                key = (3.0, -value)
            else:
                key = (4.0, i)
            rank[f"{kind}_{i + 1}"] = key
    unknown = [(5.0 if name.startswith("sensor_") else 6.0, float(i)) for i, name in enumerate(names)]
    keys = [rank.get(name, unknown[i]) for i, name in enumerate(names)]
    return sorted(range(len(names)), key=lambda i: keys[i])


def _choose(null: Array, order: list[int], J_scaled: Array) -> list[int]:
    """Return which candidates to hold: one for each null direction, preferred ones where they leave J as well conditioned."""
    r = null.shape[1]
    if r == 0:
        return []
    chosen: list[int] = []
    basis = np.zeros((0, r))
    for i in order:
        rest = null[i] - basis.T @ (basis @ null[i])
        if np.linalg.norm(rest) > _SPAN_TOLERANCE:
            chosen.append(i)
            basis = np.vstack([basis, rest / np.linalg.norm(rest)])
            if len(chosen) == r:
                break
    revealing = [int(i) for i in np.asarray(qr(null.T, mode="r", pivoting=True)[-1])[:r]]
    if (
        len(chosen) < r
        or _smallest_kept(J_scaled, chosen) < _smallest_kept(J_scaled, revealing) / _CONDITION_SLACK
    ):
        return revealing
    return chosen


def _smallest_kept(J_scaled: Array, held: list[int]) -> float:
    kept = np.delete(J_scaled, held, axis=1)
    return float(np.linalg.svd(np.linalg.qr(kept, mode="r"), compute_uv=False)[-1])


def _explain(
    names: tuple[str, ...],
    index: int,
    direction: Array,
    still: list[int],
    values: dict[str, float],
    cause: str,
) -> Held:
    """Return a held parameter with its reason, in words that a roboticist understands."""
    weight = np.abs(direction)
    others = [
        i
        for i in np.argsort(-weight, kind="stable")
        if i != index and weight[i] > _WORTH_NAMING * weight.max()
    ]
    moves_with = tuple(names[i] for i in others)
    name = names[index]
    joint = int(name.rsplit("_", 1)[1]) if name.rsplit("_", 1)[-1].isdigit() else 0
    in_target = any(not _is_robot(other) and not other.startswith("sensor_") for other in moves_with)
    if _is_scale(names, direction, values):
        reason = "nothing measured here carries a metric, so the whole cell may be scaled: every length is relative to this one"
    elif cause == "still":
        which = " and ".join(str(i) for i in still)
        one = f"it acts as one with {_listed(moves_with)}" if others else "no residual depends on it"
        reason = f"joint {which} never moves in these data, so {one}"
    elif not others:
        reason = "no residual depends on it"
    elif joint == 1 and in_target:
        reason = "the base is floating: moving it moves the whole arm, and the target is found where the arm sees it"
    else:
        reason = f"only its combination with {_listed(moves_with)} is seen"
        if cause == "poses":
            reason += " at these poses; other poses would tell them apart"
    return Held(name, reason, moves_with, cause)


def _is_robot(name: str) -> bool:
    kind, _, number = name.rpartition("_")
    return kind in GEOMETRY and number.isdigit()


def _listed(names: tuple[str, ...], most: int = 4) -> str:
    shown = list(names[:most]) + ([f"{len(names) - most} more"] if len(names) > most else [])
    return shown[0] if len(shown) == 1 else ", ".join(shown[:-1]) + " and " + shown[-1]


def _is_scale(names: tuple[str, ...], direction: Array, values: dict[str, float]) -> bool:
    """Return whether a direction stretches every length of the arm beyond the first joint in proportion.

    ``values`` leaves out what else is held: that stays where it is in every direction but its own.
    """
    ratios = []
    for i, name in enumerate(names):
        kind, _, number = name.rpartition("_")
        is_length = kind in ("a", "d") and number.isdigit() and int(number) > 1
        if is_length and abs(values.get(name, 0.0)) > 0.01:
            ratios.append(direction[i] / values[name])
    return (
        len(ratios) >= 2
        and min(np.abs(ratios)) > 0
        and float(np.ptp(ratios)) < 0.05 * float(np.max(np.abs(ratios)))
    )


PLAUSIBLE_LENGTH = 5e-3  # m: how far a length may be from the data sheet
PLAUSIBLE_ANGLE = 0.0175  # rad, a degree: the same for an angle
PLAUSIBLE_SENSOR = (0.05, 0.2)  # m, rad: a sensor's place is known less well
_ENOUGH_TO_JUDGE = 10  # degrees of freedom for the residual to say how large the noise is
PLAUSIBLE_TARGET = 10.0  # m, rad: nothing is known of the target


def anchors(residuals: Residuals, model: Model, free: Array, found: Model) -> tuple[Anchor, ...]:
    """Return what keeps robot and sensor near the data sheet where the data determine them no better than it does.

    In units of what is plausible, ``J s``, a direction whose standard error exceeds 1 is weak. The noise is that of the residual which
    neither one step of the model nor a fit removes, so that what the model lacks counts. Where no direction is weak nothing is anchored.
    Where one is, every length and angle is, each by how far it may plausibly be off: what is seen well does not feel it.

    Args:
        residuals: Of the dataset.
        model: At the start.
        free: ``(P,)`` bool.
        found: Where a fit from there ended, without anchors: a start may be too far off for one step.
    """
    residual, J = residuals.linearise(model)
    scatter, lines = _apart_from_scatter(residuals, model)
    left = residuals.residual(found)
    after = float(left @ left) - _apart_from_scatter(residuals, found)[0]
    index = np.flatnonzero(free)
    k = len(index)
    scale = plausible(model)
    factor = np.asarray(np.linalg.qr(np.column_stack([J[:, index] * scale[index], residual]), mode="r"))
    freedom = lines - k
    excess = min(float(np.sum(factor[k:, -1] ** 2)) - scatter, after)
    noise = max(float(np.sqrt(excess / freedom)), 1.0) if freedom >= _ENOUGH_TO_JUDGE and excess > 0 else 1.0
    _, s, Vt = np.linalg.svd(factor[:k, :k])
    if s[-1] >= noise:
        return ()
    weak = s < noise
    spread = noise * np.sqrt(np.sum((Vt[weak].T / np.maximum(s[weak], 1e-12)) ** 2, axis=1)) * scale[index]
    kept = []
    for i, std in zip(index, spread, strict=True):
        name, is_angle = model.names[i], model.units[i] == "rad"
        if i >= model.blocks["target"].start or name.startswith("sensor_r"):
            continue
        value = model.nominal.geometry.ravel()[i] if i < model.blocks["geometry"].stop else model.vector[i]
        reason = ""
        if std > scale[i] / 2:
            size = f"{std / DEG:.2g} deg" if is_angle else f"{std / MM:.2g} mm"
            reason = (
                f"these poses alone determine it only to about {size}, no better than the data sheet does"
            )
        kept.append(Anchor(name, float(value), float(scale[i] / noise), reason))
    return tuple(kept)


def _apart_from_scatter(residuals: Residuals, model: Model) -> tuple[float, int]:
    """Return the squared scatter of points about their own scans' lines, which no model explains, and the number of other rows."""
    measurement, N = residuals.measurement, len(residuals.poses)
    if not isinstance(measurement, LineLaser):
        return 0.0, N * measurement.rows_per_pose
    within, _ = measurement.scatter(residuals.kinematics(model).T_base_sensor, model.target)
    return float(within.sum()), int(
        np.minimum(np.diff(measurement.starts), measurement.equations_per_pose).sum()
    )


def plausible(model: Model) -> Array:
    """Return how far each coordinate may be from where it is said to be, ``(P,)`` [m or rad]."""
    blocks = model.blocks
    scale = np.full(len(model.names), PLAUSIBLE_TARGET)
    lengths = np.array([unit == "m" for unit in model.units])
    scale[blocks["geometry"]] = np.where(lengths[blocks["geometry"]], PLAUSIBLE_LENGTH, PLAUSIBLE_ANGLE)
    scale[blocks["sensor"]] = np.where(lengths[blocks["sensor"]], *PLAUSIBLE_SENSOR)
    return scale
