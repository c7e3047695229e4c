"""Which poses agree with one robot, sensor and set of planes: first coarsely with the arm nominal, then with a fitted geometry.

Both steps are least trimmed squares by concentration (Rousseeuw and Van Driessen, 2006): the model is fitted to those poses that fit best, these
are chosen anew by the fitted model, and so on until the choice no longer changes. Successive poses of one plane that are all off are a change of
the set-up (a plane that was knocked, a sensor that slipped), not outliers, and stay.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import Undetermined
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import EstimationSettings, GrossErrorSettings
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors import Measurement, measure
from scalar.sensors.robust_scale import robust_std

_ROUNDS = 12  # most rounds of fitting and setting aside; usually nothing changes after two
_CONCENTRATIONS = 4  # fits to the best-fitting poses; later ones change nothing
_LEAST_RETURNS = 3  # poses at one place; with fewer, none could be left out
LEAST_TRUSTED = 3  # poses of every plane, place or session: as many as determine where it is
_FEW_OF_SESSION = 6  # poses of a session; with some of so few left out, the others hardly determine its place
_LEAST_RETURNING = 0.5  # share of the poses that has to be at such places
# Bounds of the share of poses that are off, from which the length of runs by chance is computed.
_LEAST_SHARE, _MOST_SHARE = 1e-3, 0.95


def pose_distances(measurement: Measurement, T_base_sensor: Array, planes: Planes, index: Array) -> Array:
    """Return the root mean square distance of every pose's points to a plane, ``(N,)`` [m].

    Args:
        measurement: The dataset as rows.
        T_base_sensor: ``(N, 4, 4)``.
        planes: The K planes.
        index: ``(N,)``, the plane with which each pose is compared.
    """
    heights, starts = point_heights(measurement, T_base_sensor, planes, index)
    return np.sqrt(np.add.reduceat(heights * heights, starts[:-1]) / np.diff(starts))


def point_heights(
    measurement: Measurement, T_base_sensor: Array, planes: Planes, index: Array
) -> tuple[Array, Array]:
    """Return how far each point lies in front of a plane ``(P,)`` [m], and where those of each pose begin ``(N + 1,)``; arguments as above."""
    points, starts = measurement.points_in_base(T_base_sensor)
    of_point = np.repeat(index, np.diff(starts))
    return np.sum(points * planes.normals[of_point], axis=1) - planes.distances[of_point], starts


def coarsely_consistent(dataset: Dataset, usable: Array, settings: GrossErrorSettings) -> Array:
    """Return which poses ``(N,)`` bool agree roughly with the planes, the arm and the sensor being nominal.

    Args:
        dataset: What was measured.
        usable: ``(N,)`` bool, the poses to judge; all of them are kept if there are no planes or no nominal pose of the sensor.
        settings: Thresholds.
    """
    T_flange_sensor = dataset.sensor.T_flange_sensor
    if not dataset.planes or T_flange_sensor is None:
        return usable
    T = dataset.robot.flange(dataset.q) @ T_flange_sensor
    measurement = measure(dataset)
    guess = measurement.initial_target(dataset)
    assert isinstance(guess, Planes)
    index = measurement.target_index
    planes, keep = guess, usable
    distance = pose_distances(measurement, T, planes, index)
    for _ in range(_ROUNDS):
        core = best_fitting(dataset, distance, usable, settings)
        subset = dataset.subset(core)
        fitted = measure(subset)
        planes_found: Any = fitted.fitted_target(T[core], fitted.initial_target(subset))
        planes = _merged(planes, planes_found)
        distance = pose_distances(measurement, T, planes, index)
        limit = max(settings.coarse_pose_error, settings.pose_sigmas * robust_std(distance[core]))
        new = usable & (distance < limit)
        if np.array_equal(new, keep):
            break
        keep = new
    return keep


def _merged(planes: Planes, found: Planes) -> Planes:
    """Return planes with the normals and distances of those planes that were found, by their names."""
    normals, distances = planes.normals.copy(), planes.distances.copy()
    for name, normal, distance in zip(found.names, found.normals, found.distances, strict=True):
        k = planes.names.index(name) if name in planes.names else None
        if k is not None:
            normals[k], distances[k] = normal, distance
    return Planes.at(planes.names, normals, distances)


def finely_consistent(dataset: Dataset, keep: Array, settings: EstimationSettings) -> tuple[Array, Array]:
    """Return which poses ``(N,)`` bool agree with a calibration of the geometry, and the distances ``(N,)`` [m] by which this was judged.

    Poses that do not agree would distort a fit to all poses. The geometry is therefore first fitted to the poses that fit best, until their choice
    no longer changes, and then to all poses that agree with this fit.

    Args:
        dataset: What was measured.
        keep: ``(N,)`` bool, the poses that are usable so far.
        settings: Thresholds.

    Raises:
        InvalidInput: The initial guess of a plane is too far off for the fit.
        Undetermined: The data cannot determine the model.
    """
    gross = settings.gross_errors
    refuse_lost_session(dataset, keep)
    model, prepared = geometry_fit(dataset if keep.all() else dataset.subset(keep), settings)
    distance = distances_under(dataset, model)
    # Thirty free parameters adapt to a single wrong pose and spread its error of centimetres over all others. The size of the distances shows
    # that; their ratios need not.
    if np.all(distance[keep] < gross.least_pose_error) and not _heavy_tailed(distance[keep], gross):
        return _agreeing(dataset, distance, keep, gross), distance
    usable, by_all = keep, distance
    core = usable
    for _ in range(_CONCENTRATIONS):
        better = best_fitting(dataset, _left_out(dataset, model, prepared.free, core), usable, gross)
        if np.array_equal(better, core):
            break
        core = better
        refuse_lost_session(dataset, core)
        model, prepared = geometry_fit(dataset.subset(core), settings)
        distance = distances_under(dataset, model)
    keep = _agreeing(dataset, distance, core, gross)
    for _ in range(_ROUNDS):
        if keep.sum() < (1 - gross.most_set_aside) * dataset.n_poses:
            return keep, distance
        refuse_lost_session(dataset, keep)
        if np.array_equal(keep, usable):
            distance = by_all
        else:
            distance = distances_under(dataset, geometry_fit(dataset.subset(keep), settings)[0])
        new = _agreeing(dataset, distance, keep, gross)
        if np.array_equal(new, keep):
            break
        keep = new
    return keep, distance


def refuse_lost_session(dataset: Dataset, keep: Array) -> None:
    """Refuse a dataset in which no pose of a session agrees with the others: nothing then says where base and target stood in it.

    Planes are named by their session, and those without a pose are refused or left out with their names.

    Raises:
        Undetermined: There is such a session.
    """
    if dataset.session is None or dataset.planes:
        return
    lost = ~np.isin(dataset.session, dataset.session[keep])
    if lost.any():
        names = dict.fromkeys(str(name) for name in dataset.poses["session"].to_numpy()[lost])
        raise Undetermined(
            [f"no pose of session {', '.join(names)} agrees with the rest of the poses, even with a place of its own for base, sensor and target: "
             "check whether its measurements belong to its joint angles, or leave the session out"]
        )  # fmt: skip


def _left_out(dataset: Dataset, model: Model, free: Array, trained: Array) -> Array:
    """Return the lengths ``(N,)`` of the poses' ``deletion_residuals``.

    Args:
        dataset: All poses.
        model: Fitted to some of them.
        free: ``(P,)`` bool.
        trained: ``(N,)`` bool, the poses that it was fitted to; for the others, the residual is taken as it is.
    """
    residuals = Residuals.of(dataset, model).reweighted(model)
    residual, jacobian = residuals.linearise(model)
    N, m = dataset.n_poses, residuals.measurement.rows_per_pose
    J = jacobian[:, free] / np.maximum(np.linalg.norm(jacobian[:, free], axis=0), 1e-300)
    used = J[np.r_[np.repeat(trained, m), np.ones(len(J) - N * m, dtype=bool)]]
    measured = J[: N * m]
    solved = np.linalg.lstsq(used.T @ used, measured.T, rcond=1e-12)[0]
    H = np.einsum("nmf,fnk->nmk", measured.reshape(N, m, -1), solved.reshape(-1, N, m))
    H[~trained] = 0.0
    return np.linalg.norm(deletion_residuals(H, residual[: N * m].reshape(N, m)), axis=1)


def deletion_residuals(leverages: Array, residual: Array) -> Array:
    """Return the whitened residual ``(N, m)`` that each pose would have if the fit had been made without it: ``(I - H_ii)^-1 r_i``.

    Args:
        leverages: ``(N, m, m)``, the blocks H_ii of the fit; zero for a pose that it was not made with.
        residual: ``(N, m)``, the whitened residuals r_i.
    """
    # I - H is singular for a pose that alone determines a direction.
    kept = (1.0 + 1e-6) * np.eye(residual.shape[1]) - leverages
    return np.linalg.solve(kept, residual[:, :, None])[:, :, 0]


def outlier_limit(trusted: Array, settings: GrossErrorSettings) -> float:
    """Return the distance [m] beyond which a pose is off, from the distances ``(N,)`` [m] of poses that are trusted."""
    return max(settings.least_pose_error, settings.pose_sigmas * robust_std(trusted))


def _heavy_tailed(distances: Array, settings: GrossErrorSettings) -> bool:
    """Return whether a few poses are so much farther off than most that they may have distorted the fit."""
    return float(np.sqrt(np.mean(distances**2))) > settings.heavy_tail * float(np.median(distances))


def _agreeing(dataset: Dataset, distance: Array, trusted: Array, settings: GrossErrorSettings) -> Array:
    """Return which poses ``(N,)`` bool are no outliers given those that are trusted, or belong to runs of poses that are all off."""
    agrees = distance < outlier_limit(distance[trusted], settings)
    return agrees | (in_runs(dataset, ~agrees, settings) & (distance < settings.coarse_pose_error))


def best_fitting(dataset: Dataset, distance: Array, usable: Array, settings: GrossErrorSettings) -> Array:
    """Return which poses ``(N,)`` bool are trusted at first: of the usable poses on every plane, the share with the smallest distances.

    Where a tracker's target returns to a few places, the share is taken of the poses at every place: without a pose at one of two places in a
    session, the orientation of the tracker's frame is not determined there, and all poses at the other place would seem to be off.

    Of a tracker's session of few poses, the best three are trusted in any case: with fewer, the others hardly determine where base and sensor stood,
    and each then seems to be off.
    """
    core = np.zeros(len(usable), dtype=bool)

    def trust(group: Array, share: float) -> None:
        best = group[np.argsort(distance[group], kind="stable")]
        core[best[: max(int(np.ceil(share * len(best))), LEAST_TRUSTED)]] = True

    index = dataset.plane_index if dataset.planes else places_returned_to(dataset)
    for k in np.unique(index):
        trust(np.flatnonzero((index == k) & usable), settings.core_share)
    if dataset.session is not None and not dataset.planes:
        for name in np.unique(dataset.session[usable]):
            mine = np.flatnonzero((dataset.session == name) & usable)
            if len(mine) <= _FEW_OF_SESSION and core[mine].sum() < LEAST_TRUSTED:
                trust(mine, 0.0)
    return core


def places_returned_to(dataset: Dataset) -> Array:
    """Return an index ``(N,)`` of the place of every pose at which a target was measured, exactly alike in at least three poses of a session.

    It is 0 for all poses unless most of them are at such places, as with a ball that is put into sockets whose places are stated. A tracker that
    lost its target repeats a reading too, but in few poses, and these contradict the others.
    """
    no_place = np.zeros(dataset.n_poses, dtype=int)
    if np.any(np.diff(dataset.starts) != 1):
        return no_place
    session = no_place if dataset.session is None else dataset.session
    read = np.column_stack([session, dataset.points])
    index, counts = np.unique(read, axis=0, return_inverse=True, return_counts=True)[1:]
    index = index.ravel()
    often = counts[index] >= _LEAST_RETURNS
    return np.where(often, index + 1, 0) if often.mean() > _LEAST_RETURNING else no_place


def distances_under(dataset: Dataset, model: Model) -> Array:
    """Return the root mean square distance of every pose from its target ``(N,)`` [m], by a model that may have been fitted to some of them."""
    residuals = Residuals.of(
        dataset, Model(model.robot, model.nominal, model.reference_rotation, model.sensor, model.target)
    )
    return residuals.pose_distances(model)


def in_runs(dataset: Dataset, off: Array, settings: GrossErrorSettings) -> Array:
    """Return which of the poses that are off ``(N,)`` bool belong to runs: successive poses of one plane that are all off.

    A run counts if it is longer than ``settings.contiguous_run`` and than runs of scattered outliers would be by chance.
    """
    runs = np.zeros_like(off)
    for k in np.unique(dataset.plane_index):
        mine = np.flatnonzero(dataset.plane_index == k)
        edges = np.flatnonzero(np.diff(np.r_[0, off[mine].astype(int), 0]))
        share = min(max(float(off[mine].mean()), _LEAST_SHARE), _MOST_SHARE)
        by_chance = np.log(settings.run_by_chance / len(mine)) / np.log(share)
        for begin, end in zip(edges[::2], edges[1::2], strict=True):
            if end - begin >= max(settings.contiguous_run, by_chance):
                runs[mine[begin:end]] = True
    return runs
