"""Whether measured orientations are those of the arm, before any fit: if they are read in the wrong way, they pull a fit far from the positions.

In a pose i, ``R_tracker_base R_i R_flange_target = M_i`` with the nominal arm's R_i and the measured M_i. The two other rotations are constant, and
known in closed form (``scalar.estimation.orientation_frames``); what remains is compared. Where the measured positions show the first of the two, it
is taken from them, because with both free some wrong readings fit as well. A real arm's orientations differ from the nominal one's by a degree or
two.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from scalar.data.dataset import Dataset
from scalar.data.formats import ORIENTATION
from scalar.errors import Fault, InvalidInput
from scalar.estimation.orientation_frames import (
    Orientations,
    angles_left,
    constants,
    vectors_of,
    were_measured,
)
from scalar.estimation.setup.explain import AS_GOOD, FALLS_TO, MOST_LEFT, SINGLE, explain
from scalar.estimation.setup.plausibility import DISAGREEMENT
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.estimation.setup.trial import full_fit, quick_fit, thinned
from scalar.geometry.se3 import Array, exp_so3, nearest_rotation, rotation_angle
from scalar.sensors import measure
from scalar.units import DEG, MM

_FILE, _COLUMN = "points.csv", "rx,ry,rz"
_EULER_AXES = ("xyz", "XYZ", "ZYX", "ZYZ")  # capitals: about moving axes; "xyz" is roll, pitch and yaw
_MISREAD_AXES = ("ZYX", "zyx", "XYZ", "xyz")  # of Euler angles that an import may have taken for one another
_ROUNDING = 1e-6  # of rotations that are the same
_NEARLY_HALF_A_TURN = 3.0  # rad: beyond it, a small error may turn the axis round
_WIDE = 50.0  # times what the positions leave: over places that are spread as far, a frame is known to about a degree
_INVERSE, _SWAPPED = "inverse", "swapped"  # kinds of readings
_LEAST_POSES = 4  # with fewer, a few turns may agree by chance


def refuse_wrong_orientations(dataset: Dataset) -> None:
    """Refuse a dataset whose measured orientations are not those of the arm although its positions are; do nothing if none were measured.

    Raises:
        InvalidInput: Read in another way (inverted, alone or with the positions, as Euler angles, in degrees) they are; or another description of
            the set-up explains them alone; or nothing does, and positions alone fit.
        WrongSetup: Another description of the set-up explains both.
    """
    if not were_measured(dataset) or dataset.n_poses < _LEAST_POSES:
        return
    some = thinned(dataset)
    free = disagreement(some)
    frames = frames_by_positions(some)
    as_read = free if frames is None else max(free, disagreement(some, frames=frames))
    if as_read <= DISAGREEMENT:
        return
    most = min(DISAGREEMENT, FALLS_TO * as_read)
    readings = list(_readings(some, frames))
    # Constant frames may make two readings the same; the more usual one comes first.
    least = AS_GOOD * min(reading.left for reading in readings)
    alike = [reading for reading in readings if reading.left <= least]
    best = alike[0]
    if best.left <= most:
        if best.kind == _INVERSE:
            _refuse_inverse_poses(dataset)
        swapped = [reading.says for reading in alike if reading.kind == _SWAPPED]
        message = f"they are {best.says}: {_then(best.left, as_read)}; {best.remedy}"
        # Where both frames are free, quaternions in the wrong order cannot be distinguished from inverse rotations.
        if swapped and best.kind != _SWAPPED:
            either = " or ".join(swapped)
            message += f". They fit as well as {either}: if the file has quaternions, correct qw, qx, qy and qz in the mapping, and not the signs"
        fault = Fault(_FILE, message, column=_COLUMN)
        raise InvalidInput([fault])
    if free <= DISAGREEMENT:
        _refuse_if_positions_fit(dataset, as_read)
        return
    found = [
        (disagreement(other.dataset), other) for other in itertools.chain(*(each(some) for each in SINGLE))
    ]
    explaining = sorted((entry for entry in found if entry[0] <= most), key=lambda entry: entry[0])
    if explaining:
        suspicions = explain(dataset)
        if suspicions:
            raise WrongSetup(suspicions)
        left, best = explaining[0]
        raise InvalidInput(
            [Fault("dataset.yaml", f"{best.says}: {best.changed} {_then(left, as_read)}; {best.remedy}")]
        )
    _refuse_if_positions_fit(dataset, as_read)


def _refuse_inverse_poses(dataset: Dataset) -> None:
    """Refuse whole poses that are those of the tracker in the target's frame, as hand-eye programs have them; do nothing if they are not.

    Raises:
        InvalidInput: The positions of the inverse poses fit.
    """
    inverse = -np.einsum("pji,pj->pi", exp_so3(vectors_of(dataset)), dataset.points)
    trial = full_fit(without_orientations(replace(dataset, points=inverse)))
    if trial is None or trial.rms > MOST_LEFT:
        return
    message = (
        "these are the poses of the tracker in the frame of the target, and needed are those of the target in the frame of the tracker: with all of "
        f"them inverted the positions alone fit to {trial.rms / MM:.2g} mm; invert them (with R the rotation of a row, and p its place: R' and -R' p)"
    )
    raise InvalidInput([Fault(_FILE, message, column="x,y,z,rx,ry,rz")])


def _refuse_if_positions_fit(dataset: Dataset, as_read: float) -> None:
    """Refuse orientations that no reading explains if the positions alone fit.

    Args:
        dataset: What was measured.
        as_read: How much they differ from the arm's [rad].

    Raises:
        InvalidInput: The positions fit.
    """
    trial = full_fit(without_orientations(dataset))
    if trial is None or trial.rms > MOST_LEFT:
        return
    message = (
        f"these orientations differ from the arm's by {as_read / DEG:.0f} degrees, the positions alone fit to {trial.rms / MM:.2g} mm: they have to "
        "be rotation vectors (the axis times the angle, in radians) from the target's axes to the tracker's; convert them (if 'scalar import' did, "
        "is euler_axes of the mapping right?), or leave the columns out to calibrate with positions alone"
    )
    raise InvalidInput([Fault(_FILE, message, column=_COLUMN)])


def frames_by_positions(dataset: Dataset) -> Array | None:
    """Return the rotation from the base to the tracker in each pose ``(N, 3, 3)`` by the measured positions alone.

    None is returned where these do not fit, or lie so near a line that they leave a turn about it open.

    An arm whose axes are all parallel turns its flange about one direction only. Its orientations then agree with those of a tracker whose axes
    point elsewhere, and with the inverse rotations; the positions say where the tracker's axes point.
    """
    nominal, model = quick_fit(without_orientations(dataset))
    if model is None or nominal.rms > MOST_LEFT:
        return None
    # A sensor that measures orientations has a rotation from the base for each session.
    target: Any = model.target
    session = measure(dataset).target_index
    places = model.robot.flange(dataset.q)[:, :3, 3]
    for k in np.unique(session):
        own = places[session == k] - places[session == k].mean(axis=0)
        if np.linalg.svd(own, compute_uv=False)[1] < _WIDE * nominal.rms * np.sqrt(len(own)):
            return None
    return target.rotations[session]


def _then(left: float, as_read: float) -> str:
    return f"the orientations then differ from the arm's by {left / DEG:.2g} degrees instead of {as_read / DEG:.0f}"


def disagreement(dataset: Dataset, measured: Array | None = None, frames: Array | None = None) -> float:
    """Return the median over the points of the angle between measured orientations and the nominal arm's [rad], both constant frames fitted.

    Args:
        dataset: What was measured. Each target and each session has frames of its own; the largest of their medians is returned, 0 if none has
            enough poses.
        measured: ``(P, 3, 3)``, from a target's axes to the tracker's, of all points; None for the rotation vectors of the dataset.
        frames: ``(N, 3, 3)``, the rotation from the base to the tracker in each pose, which is then not fitted.
    """
    given = Orientations.of(dataset)
    arm, measured = given.arm, exp_so3(given.vectors) if measured is None else measured
    found = [
        _angle_left(arm[mine], measured[mine])
        if frames is None
        else _angle_left_in(frames[dataset.pose_of_point][mine] @ arm[mine], measured[mine])
        for mine in given.groups()
        if np.sum(mine) >= _LEAST_POSES
    ]
    return max(found, default=0.0)


def _angle_left(arm: Array, measured: Array) -> float:
    """Return the median angle [rad] between ``measured`` and ``Y arm X`` for the rotations X and Y that fit best; arguments ``(N, 3, 3)``."""
    # Neighbours in this order turn by different angles about different axes.
    order = np.argsort(rotation_angle(np.swapaxes(arm, 1, 2) @ arm[0]))
    X, Y = constants(arm, measured, order, np.roll(order, len(order) // 2), _NEARLY_HALF_A_TURN)
    return float(np.median(angles_left(arm, measured, X, Y)))


def _angle_left_in(arm: Array, measured: Array) -> float:
    """Return the median angle [rad] between ``measured`` and ``arm X`` for the rotation X that fits best; arguments ``(N, 3, 3)``."""
    X = nearest_rotation(np.sum(np.swapaxes(arm, 1, 2) @ measured, axis=0))
    return float(np.median(rotation_angle(np.swapaxes(arm @ X, 1, 2) @ measured)))


@dataclass(frozen=True)
class _Reading:
    """Another reading of the columns rx,ry,rz.

    Attributes:
        left: The disagreement that it leaves [rad].
        says: What the columns then are, after "they are".
        remedy: What to do.
        kind: ``_INVERSE``, ``_SWAPPED`` (quaternions in another order), or empty.
    """

    left: float
    says: str
    remedy: str
    kind: str = ""


def _readings(dataset: Dataset, frames: Array | None) -> Iterator[_Reading]:
    """Yield other readings of the columns rx,ry,rz.

    Args:
        dataset: What was measured.
        frames: As ``frames_by_positions`` returns them.
    """
    vectors = vectors_of(dataset)
    convert = "write rotation vectors (the axis times the angle, in radians); 'scalar import' converts Euler angles (euler_axes in the mapping)"
    inverse = "the inverse rotation, from the tracker's axes to the target's"
    left = disagreement(dataset, exp_so3(-vectors), frames)
    yield _Reading(left, inverse, "change the sign of all three columns", _INVERSE)
    as_read = np.roll(Rotation.from_rotvec(vectors).as_quat(), 1, axis=1)  # qw, qx, qy, qz
    for roll, read, is_ in ((0, "qw,qx,qy,qz", "qx,qy,qz,qw"), (-2, "qx,qy,qz,qw", "qw,qx,qy,qz")):
        R = Rotation.from_quat(np.roll(as_read, roll, axis=1)).as_matrix()
        says = f"quaternions whose columns are {is_} and were read as {read}"
        yield _Reading(
            disagreement(dataset, R, frames), says, "exchange the columns in the mapping", _SWAPPED
        )
    left = disagreement(dataset, exp_so3(vectors * DEG), frames)
    yield _Reading(left, "in degrees", "multiply them by pi / 180")
    for axes in _EULER_AXES:
        kind = "moving" if axes.isupper() else "fixed"
        for unit, degrees in (("radians", False), ("degrees", True)):
            R = Rotation.from_euler(axes, vectors, degrees=degrees).as_matrix()
            says = f"Euler angles about the {kind} axes {axes.lower()} in {unit}"
            yield _Reading(disagreement(dataset, R, frames), says, convert)
            left = disagreement(dataset, np.swapaxes(R, 1, 2), frames)
            yield _Reading(left, f"{says} of the inverse rotation", convert)
    yield from _other_axes(dataset, frames)


def _other_axes(dataset: Dataset, frames: Array | None) -> Iterator[_Reading]:
    """Yield readings in which the Euler angles that an import converted turn about other axes than its mapping states; as ``_readings``."""
    as_read = Rotation.from_rotvec(vectors_of(dataset))
    # Angles in the other order about axes in the other order are the same rotation.
    alike: list[tuple[Array, list[str]]] = []
    for stated, meant in itertools.permutations(_MISREAD_AXES, 2):
        R = Rotation.from_euler(meant, as_read.as_euler(stated)).as_matrix()
        what = f"{meant} if it states {stated}"
        same = [words for other, words in alike if np.allclose(other, R, rtol=0.0, atol=_ROUNDING)]
        if same:
            same[0].append(what)
        else:
            alike.append((R, [what]))
    for R, words in alike:
        remedy = f"if 'scalar import' made them, write euler_axes: {', or '.join(words)} in the mapping, and import again"
        says = "Euler angles about other axes than they were read with"
        yield _Reading(disagreement(dataset, R, frames), says, remedy)


def without_orientations(dataset: Dataset) -> Dataset:
    """Return the dataset with the measured positions alone."""
    kept = {
        name: values
        for name, values in dataset.point_columns.items()
        if name not in (*ORIENTATION, "rotation_noise")
    }
    return replace(dataset, point_columns=kept)
