"""Set gross errors aside before anything is explained: points off their own scan, poses far off every plane, wrong plane labels.

Nothing is deleted from anyone's files: what is set aside is listed. Gross means far beyond what an effect does to an arm, millimetres where
effects make tenths, and scattered: a run of successive poses that are all off is a change (a knocked plate, a slipped sensor), not outliers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.errors import InvalidInput, ScalarError, Undetermined
from scalar.estimation.least_squares import fit
from scalar.estimation.model import Model
from scalar.estimation.prepare import Prepared, prepare
from scalar.estimation.residuals import Residuals
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors import measure
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

POINT_SIGMAS = 5.0  # robust standard deviations of a scan beyond which a point is off its own line
LEAST_POINT_ERROR = 2e-4  # m; and never less than this
LEAST_POINTS = 5  # of a scan, for a line to have outliers
POSE_SIGMAS = 10.0  # robust standard deviations beyond which a pose is off
LEAST_POSE_ERROR = 1.0 * MM  # and never less than this
COARSE_POSE_ERROR = 20.0 * MM  # with the arm still nominal, whose own errors make several millimetres
LABEL_RATIO = 0.2  # a pose is mislabelled where another plane is nearer than this share of its own distance
CORE_SHARE = 0.6  # of the poses on a plane that are trusted at first
MOST_SET_ASIDE = 0.45  # of the poses: with more, nothing can be said of which are right
MOST_LATE = 0.02  # of the poses: with more that only stand out beside effects, the effects are not yet right
CONTIGUOUS_RUN = 4  # successive poses of one plane that are all off are a change, not outliers
RUN_BY_CHANCE = 0.05  # expected number of runs as long that scattered outliers would make
_MADE_NORMAL = 1.4826  # median absolute deviation to standard deviation
_ROUNDS = 12
_CONCENTRATIONS = 4
_HEAVY_TAIL = (
    2.0  # root mean square over median of the poses' distances; a chi law of two numbers has about 1.2
)


@dataclass(frozen=True, eq=False)
class Cleaned:
    """A dataset without its gross errors, and what was set aside.

    Attributes:
        dataset: What remains.
        outlier_poses: Ids of poses that lie on no plane.
        mislabelled_poses: Ids of poses that lie on another plane than said, with that plane's name.
        points: Number of points set aside within the remaining scans.
    """

    dataset: Dataset
    outlier_poses: tuple[int, ...]
    mislabelled_poses: tuple[tuple[int, str], ...]
    points: int


def clean(dataset: Dataset) -> Cleaned:
    """Return a dataset without gross errors.

    Raises:
        Undetermined: So much is off that nothing can be said of what is right.
    """
    dataset, n_points, torn = without_outlying_points(dataset)
    keep = ~torn
    keep &= _coarsely_consistent(dataset, keep)
    try:
        keep = _finely_consistent(dataset, keep)
    except InvalidInput as error:
        # What contradicts the rough planes may be the planes or the labels: the data themselves cannot say which.
        raise Undetermined(
            [
                *(str(fault) for fault in error.faults),
                "until labels and rough planes agree, nothing can be said of what the model lacks",
            ]
        ) from None
    off = [int(i) for i in np.flatnonzero(~keep)]
    if len(off) > MOST_SET_ASIDE * dataset.n_poses:
        raise Undetermined(
            [f"{len(off)} of {dataset.n_poses} poses contradict the rest: no part of the data can be trusted over another; "
             "check the plane labels in poses.csv, the nominal robot and the units"]
        )  # fmt: skip
    labels = _other_labels(dataset, keep, off)
    ids = dataset.pose_ids
    return Cleaned(
        dataset.subset(keep) if len(off) else dataset,
        tuple(int(ids[i]) for i in off if i not in labels),
        tuple((int(ids[i]), labels[i]) for i in off if i in labels),
        n_points,
    )


def clean_beside(cleaned: Cleaned, distance: Array) -> Cleaned:
    """Return what was cleaned without poses that are off now that effects are known; the same object where there are none.

    A plate that moved, or an arm that sags, is noise to the first look, behind which a gross error may hide.

    Args:
        cleaned: By the first look.
        distance: ``(N,)`` [m], of every pose that remains, root mean square, effects applied.
    """
    dataset = cleaned.dataset
    off = distance >= _limit(distance)
    off &= ~_in_runs(dataset, off)
    if not off.any() or off.sum() > MOST_LATE * dataset.n_poses:
        return cleaned
    late = tuple(int(pose) for pose in dataset.pose_ids[off])
    return replace(cleaned, dataset=dataset.subset(~off), outlier_poses=cleaned.outlier_poses + late)


def without_outlying_points(dataset: Dataset) -> tuple[Dataset, int, Array]:
    """Return the dataset without points that are off their own scan's line, their number, and which scans are torn.

    Each scan's line is found by iterated reweighting towards least absolute distance, which forgives a third of wrong points; a scan with
    more than that off its line is torn and is set aside whole.
    """
    counts = np.diff(dataset.starts)
    torn = np.zeros(dataset.n_poses, dtype=bool)
    if dataset.sensor.kind != "line-laser" or counts.max(initial=0) < LEAST_POINTS:
        return dataset, 0, torn
    first = dataset.starts[:-1]
    scan = np.repeat(np.arange(len(counts)), counts)
    distance = np.zeros(len(dataset.points))
    weight = np.ones(len(dataset.points))
    scale = np.full(len(counts), np.inf)
    for _ in range(_ROUNDS):
        distance = np.abs(_line_distance(dataset.points, weight, first, scan))
        scale = np.maximum(_MADE_NORMAL * _median_within(distance, scan, first, counts), 1e-9)
        weight = 1.0 / np.maximum(distance / scale[scan], 0.3)
    floor = np.median(scale)  # a short scan's own spread is low by chance now and then
    limit = np.maximum(POINT_SIGMAS * np.maximum(scale, floor), LEAST_POINT_ERROR)
    off = (distance > limit[scan]) & (counts[scan] >= LEAST_POINTS)
    share = np.add.reduceat(off.astype(float), first) / counts
    torn = share > 1.0 / 3.0
    drop = off & ~torn[scan]
    if not drop.any():
        return dataset, 0, torn
    kept = counts - np.add.reduceat(drop.astype(int), first)
    return (
        replace(dataset, points=dataset.points[~drop], starts=np.r_[0, np.cumsum(kept)]),
        int(drop.sum()),
        torn,
    )


def _line_distance(points: Array, weight: Array, first: Array, scan: Array) -> Array:
    """Return the signed distance of every point to its scan's weighted line of total least squares."""
    total = np.add.reduceat(weight, first)
    mean = np.add.reduceat(points * weight[:, None], first) / total[:, None]
    centred = points - mean[scan]
    sxx, sxz, szz = (
        np.add.reduceat(weight * centred[:, i] * centred[:, j], first) for i, j in ((0, 0), (0, 1), (1, 1))
    )
    angle = 0.5 * np.arctan2(2 * sxz, sxx - szz)
    return centred[:, 1] * np.cos(angle)[scan] - centred[:, 0] * np.sin(angle)[scan]


def _median_within(values: Array, scan: Array, first: Array, counts: Array) -> Array:
    order = np.lexsort((values, scan))
    return values[order][first + counts // 2]


def _pose_distances(dataset: Dataset, T_base_sensor: Array, planes: Planes, index: Array) -> Array:
    """Return the root mean square distance of every pose's points to the plane of the given index ``(N,)`` [m]."""
    n, d = planes.normals[index], planes.distances[index]
    o = T_base_sensor[:, :3, 3]
    if dataset.sensor.kind != "line-laser":
        return np.abs(np.sum(n * o, axis=1) - d)
    counts = np.diff(dataset.starts)
    c = np.einsum("nkx,nx->nk", np.stack([T_base_sensor[:, :3, 0], T_base_sensor[:, :3, 2]], axis=1), n)
    offset = np.sum(n * o, axis=1) - d
    f = np.sum(dataset.points * np.repeat(c, counts, axis=0), axis=1) + np.repeat(offset, counts)
    return np.sqrt(np.add.reduceat(f * f, dataset.starts[:-1]) / counts)


def _coarsely_consistent(dataset: Dataset, usable: Array) -> Array:
    """Return which poses agree roughly with the planes, arm and sensor nominal: least trimmed squares by concentration."""
    T_flange_sensor = dataset.sensor.T_flange_sensor
    if dataset.sensor.kind == "tracker" or T_flange_sensor is None:
        return usable
    T = dataset.robot.flange(dataset.q) @ T_flange_sensor
    measurement = measure(dataset)
    guess = measurement.initial_target(dataset)
    assert isinstance(guess, Planes)
    index = measurement.target_index
    planes, keep = guess, usable
    distance = _pose_distances(dataset, T, planes, index)
    for _ in range(_ROUNDS):
        core = _core(dataset, distance, usable)
        subset = dataset.subset(core)
        fitted = measure(subset)
        planes_found: Any = fitted.fitted_target(T[core], fitted.initial_target(subset))
        planes = _merged(planes, planes_found)
        distance = _pose_distances(dataset, T, planes, index)
        limit = max(COARSE_POSE_ERROR, POSE_SIGMAS * _MADE_NORMAL * float(np.median(distance[core])))
        new = usable & (distance < limit)
        if np.array_equal(new, keep):
            break
        keep = new
    return keep


def _merged(planes: Planes, found: Planes) -> Planes:
    normals, distances = planes.normals.copy(), planes.distances.copy()
    for name, normal, distance in zip(found.names, found.normals, found.distances, strict=True):
        k = planes.names.index(name) if name in planes.names else None
        if k is not None:
            normals[k], distances[k] = normal, distance
    return Planes.at(planes.names, normals, distances)


def _finely_consistent(dataset: Dataset, keep: Array) -> Array:
    """Return which poses agree with a calibration of the geometry.

    Where some do not, a fit to all would be dragged by them: the geometry is first fitted to the better part of the poses, until that part no
    longer changes, and then taken back to all that agree with it.
    """
    model, prepared = geometry_fit(dataset.subset(keep))
    distance = _distances_under(dataset, model)
    # Thirty parameters bend towards a single wrong pose and spread its centimetres over all others, behind which it hides: no ratio of
    # distances shows it, but their size does.
    if np.all(distance[keep] < LEAST_POSE_ERROR) and not _heavy_tailed(distance[keep]):
        return _agreeing(dataset, distance, keep)
    usable = core = keep
    for _ in range(_CONCENTRATIONS):
        core = _core(dataset, _left_out(dataset, model, prepared.free, core), usable)
        model, prepared = geometry_fit(dataset.subset(core))
        distance = _distances_under(dataset, model)
    keep = _agreeing(dataset, distance, core)
    for _ in range(_ROUNDS):
        if keep.sum() < (1 - MOST_SET_ASIDE) * dataset.n_poses:
            return keep
        distance = _distances_under(dataset, geometry_fit(dataset.subset(keep))[0])
        new = _agreeing(dataset, distance, keep)
        if np.array_equal(new, keep):
            break
        keep = new
    return keep


def _left_out(dataset: Dataset, model: Model, free: Array, trained: Array) -> Array:
    """Return the whitened residual ``(N,)`` that every pose would have if the fit had been made without it: ``(I - H_ii)^-1 r_i``.

    Args:
        dataset: All poses.
        model: Fitted to some of them.
        free: ``(P,)`` bool.
        trained: ``(N,)`` bool, those that it was fitted to.
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
    kept = (1.0 + 1e-6) * np.eye(m) - H  # a pose that alone decides something would divide by nothing
    return np.linalg.norm(np.linalg.solve(kept, residual[: N * m].reshape(N, m, 1)), axis=(1, 2))


def _limit(trusted: Array) -> float:
    """Return the distance [m] beyond which a pose is off, from the distances of poses that are trusted."""
    return max(LEAST_POSE_ERROR, POSE_SIGMAS * _MADE_NORMAL * float(np.median(trusted)))


def _heavy_tailed(distances: Array) -> bool:
    """Return whether a few poses are so much farther off than most that they may have dragged the fit."""
    return float(np.sqrt(np.mean(distances**2))) > _HEAVY_TAIL * float(np.median(distances))


def _agreeing(dataset: Dataset, distance: Array, trusted: Array) -> Array:
    agrees = distance < _limit(distance[trusted])
    return agrees | (_in_runs(dataset, ~agrees) & (distance < COARSE_POSE_ERROR))


def _core(dataset: Dataset, distance: Array, usable: Array) -> Array:
    """Return the better part of the usable poses on every plane."""
    core = np.zeros(len(usable), dtype=bool)
    index = dataset.plane_index
    for k in np.unique(index):
        mine = np.flatnonzero((index == k) & usable)
        best = mine[np.argsort(distance[mine], kind="stable")]
        core[best[: max(int(np.ceil(CORE_SHARE * len(best))), 3)]] = True
    return core


def geometry_fit(dataset: Dataset) -> tuple[Model, Prepared]:
    """Return a quick fit of the geometry alone, not polished, and how it was prepared."""
    prepared = prepare(dataset)
    found = fit(prepared.residuals, prepared.near, prepared.free, tolerance=1e-6)
    return found.model.rebased(), prepared


def _distances_under(dataset: Dataset, model: Model) -> Array:
    residuals = Residuals.of(
        dataset, Model(model.robot, model.nominal, model.reference_rotation, model.sensor, model.target)
    )
    squares, counts = residuals.squared_distances(model)
    return np.sqrt(squares / counts)


def _in_runs(dataset: Dataset, off: Array) -> Array:
    """Return which of the poses that are off stand in runs of successive poses of one plane that are all off."""
    runs = np.zeros_like(off)
    for k in np.unique(dataset.plane_index):
        mine = np.flatnonzero(dataset.plane_index == k)
        edges = np.flatnonzero(np.diff(np.r_[0, off[mine].astype(int), 0]))
        share = min(max(float(off[mine].mean()), 1e-3), 0.95)
        by_chance = np.log(RUN_BY_CHANCE / len(mine)) / np.log(share)
        for begin, end in zip(edges[::2], edges[1::2], strict=True):
            if end - begin >= max(CONTIGUOUS_RUN, by_chance):
                runs[mine[begin:end]] = True
    return runs


def _other_labels(dataset: Dataset, keep: Array, off: list[int]) -> dict[int, str]:
    """Return for poses that are off the plane that they do lie on, where there is one."""
    if dataset.sensor.kind == "tracker" or not len(off):
        return {}
    try:
        model, _ = geometry_fit(dataset.subset(keep))
    except ScalarError:
        return {}
    planes = model.target
    assert isinstance(planes, Planes)
    T = dataset.robot.with_geometry(model.robot.geometry).flange(dataset.q) @ model.T_flange_sensor
    every = np.stack(
        [_pose_distances(dataset, T, planes, np.full(dataset.n_poses, k)) for k in range(len(planes.names))],
        axis=1,
    )[off]
    scale = float(np.median(_pose_distances(dataset, T, planes, measure(dataset).target_index)[keep]))
    own = [
        planes.names.index(name) if name in planes.names else -1
        for name in dataset.poses["plane"].to_numpy()[off]
    ]
    labels = {}
    for i, distances, mine in zip(off, every, own, strict=True):
        best = int(np.argmin(distances))
        near = distances[best] < max(LEAST_POSE_ERROR, POSE_SIGMAS * _MADE_NORMAL * scale)
        if best != mine and near and distances[best] < LABEL_RATIO * distances[mine]:
            labels[int(i)] = planes.names[best].split("@")[0]
    return labels
