"""Simulate workcells over many seeds, and return samples of the four errors for effects of any sizes at any setting.

The displacements of the poses by several effects are added before errors are computed from them, so the scatter of the errors
and their correlation need no further assumption.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.units import DEG, MM
from study.published_curves.curves import Setting
from study.published_curves.stops import ITERATIONS, SolverPath, follow, stops_at
from study.published_curves.workcell import Shifts, Workcell, shifts, simulate_workcell

POOL = 2000  # number of evaluation poses that are simulated, among which those with the largest errors are searched
FOR_MEAN = 250  # number of poses over which means are taken, with a standard error of about 2 %
FOR_MAX = 60  # number of further poses of the pool, those with the largest relative errors


@dataclass(frozen=True)
class Sizes:
    """The sizes of the effects; by default there is nothing but the stated noise.

    Attributes:
        noise: Factor on the stated noise of a point.
        shared: Standard deviation of noise that is common to a scan, as a share of the stated noise.
        scan: Standard deviation of an error that is common to a scan [m].
        joint: Standard deviation of the error of every joint angle [rad].
        step: Step to which ranges are rounded [m]; one of those that the ensemble was made with, or 0 for none.
        tolerance: Relative decrease of the sum of squares at which the solver stops; 0: it does not stop early.
        iterations: Number of iterations after which the solver stops; 0: it does not stop early.
    """

    noise: float = 1.0
    shared: float = 0.0
    scan: float = 0.0
    joint: float = 0.0
    step: float = 0.0
    tolerance: float = 0.0
    iterations: int = 0


@dataclass(eq=False)
class Ensemble:
    """Workcells over seeds, with draws of every unit error in each.

    Attributes:
        seeds: Seeds of the workcells.
        draws: Number of draws in each workcell.
        D: ``(P, 6, F)``, derivatives of the evaluation poses that are kept, those for the mean first, by the free coordinates, in the workcell of
            the first seed.
        units: ``{design: displacements by unit errors, one object for each seed}``.
        incidence: For each seed the mean square of n . u, with n the plane's normal and u the ray.
        paths: ``{(poses, offset, tilt): the solver's path for each of the first seeds}``.
    """

    seeds: tuple[int, ...]
    draws: int
    D: Array
    units: dict[tuple[int, int], list[Shifts]]
    incidence: Array
    paths: dict[tuple[int, float, float], list[SolverPath]]
    _fields: dict[Any, Array] = field(default_factory=dict, repr=False)
    _squares: dict[Any, float] = field(default_factory=dict, repr=False)

    def log_errors(self, setting: Setting, sizes: Sizes) -> Array:
        """Return samples ``(S, 4)`` of the logarithms of the errors in mm and degrees; the samples are ordered by seed."""
        point, scan, joint = (self._moved(setting.design, kind) for kind in ("point", "scan", "joint"))
        common = np.hypot(sizes.scan, sizes.shared * setting.sigma)
        total = point * np.float32(sizes.noise * setting.sigma)
        if common > 0:
            total += scan * np.float32(common)
        if sizes.joint > 0:
            total += joint * np.float32(sizes.joint)
        if sizes.step > 0:
            total += self._moved(setting.design, (setting.sigma, sizes.step))
        if sizes.tolerance > 0 or sizes.iterations > 0:
            total = self._stopped(setting, sizes, common, total)
        return log_errors(total)

    def shares(self, setting: Setting, sizes: Sizes) -> Array:
        """Return the shares ``(3,)`` of the squared position error that errors of points, of scans and of joints cause."""
        parts = [
            (sizes.noise * setting.sigma) ** 2 * self._square(setting.design, "point"),
            (sizes.scan**2 + (sizes.shared * setting.sigma) ** 2) * self._square(setting.design, "scan"),
            sizes.joint**2 * self._square(setting.design, "joint"),
        ]
        if sizes.step > 0:
            parts[0] += self._square(setting.design, (setting.sigma, sizes.step))
        return np.array(parts) / (sum(parts) or 1.0)

    def _square(self, design: tuple[int, int], kind: Any) -> float:
        """Return the square of the geometric mean, over samples, of the mean position error [mm] by a unit error; computed once."""
        key = design, kind
        if key not in self._squares:
            self._squares[key] = float(np.exp(2.0 * log_errors(self._moved(design, kind))[:, 0].mean()))
        return self._squares[key]

    def forget_others(self, setting: Setting) -> None:
        """Drop what was computed for other settings, since all of it together takes some hundred megabytes."""
        for key in list(self._fields):
            design, kind = key
            if design != setting.design or (isinstance(kind, tuple) and kind[0] != setting.sigma):
                del self._fields[key]

    def _moved(self, design: tuple[int, int], kind: Any) -> Array:
        """Return the displacements ``(S, P, 6)`` [rad, m] of the evaluation poses by a unit error, as float32; computed once.

        Args:
            design: Numbers of poses and of points in a scan.
            kind: ``point``, ``scan`` or ``joint``, or the pair (sigma, step) of rounded ranges.
        """
        key = design, kind
        if key not in self._fields:
            units = self.units[design]
            x = np.concatenate(
                [u.rounded[kind] if isinstance(kind, tuple) else getattr(u, kind) for u in units]
            )
            flat = self.D.reshape(-1, self.D.shape[-1])
            self._fields[key] = (x @ flat.T).reshape(len(x), *self.D.shape[:2]).astype(np.float32)
        return self._fields[key]

    def _stopped(self, setting: Setting, sizes: Sizes, common: float, total: Array) -> Array:
        """Return displacements with what a solver that stops early leaves added, for the seeds whose paths were recorded.

        Args:
            setting: The setting of the run.
            sizes: The sizes of the effects.
            common: Standard deviation of the errors that are common to a scan [m].
            total: ``(S, P, 6)``, displacements by the effects [rad, m].
        """
        paths = self.paths[setting.poses, setting.offset, setting.tilt]
        total = total[: len(paths) * self.draws]
        left = []
        for path, incidence in zip(paths, self.incidence, strict=False):
            if sizes.iterations > 0:
                at = min(sizes.iterations, ITERATIONS - 1)
            else:
                variance = (sizes.noise * setting.sigma) ** 2 + common**2 + sizes.step**2 / 12
                share = setting.points / path.points
                scaled = SolverPath(path.left, path.excess * share, setting.points)
                at = stops_at(scaled, setting.poses * setting.points * incidence * variance, sizes.tolerance)
            left.append(path.left[at])
        return total + np.repeat(np.array(left, dtype=np.float32), self.draws, axis=0)


def log_errors(moved: Array) -> Array:
    """Return the logarithms ``(S, 4)`` of the errors in mm and degrees, in the order of ``QUANTITIES``, of displacements ``(S, P, 6)`` [rad, m]."""
    squares = moved * moved
    turn, move = (np.sqrt(squares[..., k : k + 3].sum(axis=-1)) for k in (0, 3))
    errors = [move[:, :FOR_MEAN].mean(axis=1) / MM, move.max(axis=1) / MM]
    errors += [turn[:, :FOR_MEAN].mean(axis=1) / DEG, turn.max(axis=1) / DEG]
    return np.log(np.stack(errors, axis=1).astype(float))


def build_ensemble(
    config: Mapping[str, Any],
    base_dir: Path,
    seeds: Sequence[int],
    draws: int,
    settings: Sequence[Setting],
    steps: Sequence[float],
    followed: int,
    kept: Array | None = None,
) -> Ensemble:
    """Return workcells over seeds, with displacements at the designs of all settings.

    Args:
        config: Config of the scene; its poses and points per scan are set to the largest numbers of any setting.
        base_dir: Folder from which the path of the scene's robot starts.
        seeds: Seeds of the workcells.
        draws: Draws of the noise in each workcell.
        settings: The settings at which errors will be asked for.
        steps: Steps to which ranges are rounded [m].
        followed: Number of seeds, from the first on, for which the solver's path is recorded.
        kept: Indices of the evaluation poses to keep; None: they are chosen here.
    """
    designs = sorted({setting.design for setting in settings})
    sigmas = {d: sorted({s.sigma for s in settings if s.design == d}) for d in designs}
    starts = sorted({(s.poses, s.offset, s.tilt) for s in settings})
    most = max(s.poses for s in settings) // len(config["planes"])
    sensor = {**config["sensor"], "points_per_scan": max(s.points for s in settings)}
    config = {**config, "poses_per_plane": most, "sensor": sensor}
    units: dict[tuple[int, int], list[Shifts]] = {d: [] for d in designs}
    paths: dict[tuple[int, float, float], list[SolverPath]] = {s: [] for s in starts} if followed else {}
    incidence, D = [], np.zeros(0)
    for number, seed in enumerate(seeds):
        workcell = simulate_workcell({**config, "seed": seed}, base_dir, POOL)
        rng = np.random.default_rng([seed, 20181001])
        for design in designs:
            units[design].append(shifts(workcell, design, sigmas[design], steps, draws, rng))
        incidence.append(float(np.mean(workcell.incidence**2)))
        if kept is None:
            kept = _poses_to_keep(workcell.D, units[designs[-1]][0])
        if number == 0:
            D = workcell.D[kept]
        if number < followed:
            for start in starts:
                rng = np.random.default_rng([seed, 7])  # the same directions for every start
                paths[start].append(
                    follow(workcell, start[0], initial_planes(workcell, start[1], start[2], rng), kept)
                )
        print(
            f"seed {seed}: {len(designs)} designs, {len(starts) if number < followed else 0} paths",
            flush=True,
        )
    return Ensemble(tuple(seeds), draws, D, units, np.array(incidence), paths)


def _poses_to_keep(D: Array, units: Shifts) -> Array:
    """Return the indices of the poses to evaluate on: the first ``FOR_MEAN`` for means, and ``FOR_MAX`` with the largest errors.

    Args:
        D: ``(P, 6, F)``, derivatives of all evaluation poses.
        units: Displacements by unit errors.
    """
    extremeness = np.zeros(len(D))
    for x in (units.point, units.scan, units.joint):
        moved = np.einsum("pif,rf->rpi", D, x)
        for k in (0, 3):
            size = np.linalg.norm(moved[..., k : k + 3], axis=-1)
            extremeness += (size / size.max(axis=1, keepdims=True)).max(axis=0)
    order = np.argsort(-extremeness, kind="stable")
    extreme = order[order >= FOR_MEAN][:FOR_MAX]
    return np.concatenate([np.arange(FOR_MEAN), np.sort(extreme)])


def initial_planes(workcell: Workcell, offset: float, tilt: float, rng: np.random.Generator) -> Planes:
    """Return initial guesses of the planes: the true planes, shifted and tilted.

    Args:
        workcell: The workcell with its true planes.
        offset: Shift of each plane along its normal [m], whose sign is random.
        tilt: Tilt of each plane [deg], whose direction is random.
        rng: Draws signs and directions.
    """
    target = workcell.planes
    signs = rng.choice([-1.0, 1.0], len(target.normals))
    directions = rng.uniform(0.0, 2.0 * np.pi, len(target.normals))
    tangents = np.einsum(
        "kit,kt->ki", target.normal_derivatives, np.stack([np.cos(directions), np.sin(directions)], axis=1)
    )
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    normals = np.cos(tilt * DEG) * target.normals + np.sin(tilt * DEG) * tangents
    return Planes.at(target.names, normals, target.distances + signs * offset)
