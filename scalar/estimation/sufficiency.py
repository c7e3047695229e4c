"""Refuse data that cannot determine a model, before or after a first fit of the geometry; the messages say what would help."""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.description import MIN_PLANES, NO_MORE_PLANES
from scalar.data.motion import still_clause
from scalar.errors import Fault, InvalidInput, Undetermined
from scalar.estimation.identifiability import Identifiability
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS, SufficiencySettings
from scalar.estimation.unseen_directions import span_of
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors import Measurement
from scalar.sensors.compression import compress
from scalar.units import DEG

_POSES_OF_SESSION = (
    5  # on average: with fewer in each, the sessions are at fault, and not the number of poses
)
_LEAST_POINTS = 3  # on a plane: fewer lie on a line


class TooManyUnknowns(Undetermined):
    """A fit has as many unknowns as equations or more, by counting. Errors in the set-up are not searched for then: any reading could be fitted."""


def check_data(dataset: Dataset, measurement: Measurement, guess: Any) -> None:
    """Refuse data that are too few, by counting alone.

    Args:
        dataset: What was measured.
        measurement: The dataset, as the sensor kind's rows.
        guess: The initial guesses of the planes, or the tracker's frames.

    Raises:
        Undetermined: Fewer than three planes are measured, and there are not said to be no more; or there are hardly any poses.
    """
    reasons = []
    if dataset.planes and not dataset.few_planes:
        seen = sorted({dataset.planes[k].name for k in set(dataset.plane_index.tolist())})
        if len(seen) < MIN_PLANES:
            reasons.append(
                f"only {len(seen)} of the planes {', '.join(p.name for p in dataset.planes)} "
                f"{'is' if len(seen) == 1 else 'are'} measured, and at least three that are not parallel are needed: "
                f"with fewer, no measurement shows a shift of the sensor along them; measure a third plane{NO_MORE_PLANES}"
            )
    equations = int(measurement.equations.sum())
    unknowns = (6 if measurement.observes_orientation else 3) + len(guess.vector)
    if equations < unknowns:
        told = (
            f"{_poses_give(dataset.n_poses)} {equations} equations, and the places of sensor and "
            f"{measurement.target_words} alone are {unknowns} unknowns: "
        )
        sessions = 1 if dataset.session is None else len(np.unique(dataset.session))
        many = sessions > max(1.0, dataset.n_poses / _POSES_OF_SESSION)
        advice = (
            f"the column session of poses.csv has {sessions} different values, and in each session the {measurement.target_words} may stand "
            "elsewhere; give all poses between which nothing was moved the same value"
            if many
            else "measure many more poses, a hundred or so"
        )
        raise TooManyUnknowns([*reasons, told + advice])
    if reasons:
        raise Undetermined(reasons)


def check_lines(
    residuals: Residuals, model: Model, settings: SufficiencySettings = DEFAULTS.sufficiency
) -> None:
    """Refuse planes that are scanned on one line only.

    Args:
        residuals: Of the dataset.
        model: With sensor and planes as a first fit found them.

    Raises:
        Undetermined: A plane is measured along one line only.
    """
    planes = model.target
    if not isinstance(planes, Planes):
        return
    longest, second = _extents(residuals, model)
    on_a_line = second < np.maximum(
        settings.least_width * longest, settings.least_width_sigmas * residuals.measurement.sigma
    )
    reasons = [
        f"all points on plane '{name}' lie on a line, so its tilt about that line cannot be determined: "
        "scan it in other places and directions"
        for name in np.array(planes.names)[on_a_line]
    ]
    if reasons:
        raise Undetermined(reasons)


def check_span(
    dataset: Dataset,
    residuals: Residuals,
    model: Model,
    settings: SufficiencySettings = DEFAULTS.sufficiency,
) -> None:
    """Refuse scanned planes that do not span space, unless there are said to be no more.

    Args:
        dataset: What was measured.
        residuals: Of the dataset.
        model: With the planes as a fit found them.

    Raises:
        Undetermined: Naming the two planes that are nearest to parallel.
    """
    planes = model.target
    wanted = residuals.measurement.needs_spanning_planes and not dataset.few_planes
    if wanted and isinstance(planes, Planes) and span_of(planes.normals)[0][-1] < settings.least_span:
        raise Undetermined([_parallel_planes(planes)])


def check_guess(model: Model, guess: Any, settings: SufficiencySettings = DEFAULTS.sufficiency) -> None:
    """Refuse initial guesses of planes that the points contradict.

    Args:
        model: With the planes as a fit of everything found them.
        guess: The initial guesses of the planes.

    Raises:
        InvalidInput: A guessed plane is far from where the points lie: a wrong label or a wrong normal.
    """
    planes = model.target
    if not isinstance(planes, Planes):
        return
    cosine = np.abs(np.sum(planes.normals * guess.normals, axis=1))
    faults = [
        Fault(
            "dataset.yaml",
            f"the points of this plane lie on one whose normal is {np.arccos(min(c, 1.0)) / DEG:.0f} degrees from this initial "
            "guess: correct the normal, or the plane's name in poses.csv",
            None,
            f"planes.{name}.normal",
        )
        for name, c in zip(planes.names, cosine, strict=True)
        if c < np.cos(settings.farthest_guess)
    ]
    if faults:
        raise InvalidInput(faults)


def _parallel_planes(planes: Planes) -> str:
    cosines = np.abs(planes.normals @ planes.normals.T) - np.eye(len(planes.normals))
    i, j = np.unravel_index(int(np.argmax(cosines)), cosines.shape)
    angle = np.arccos(min(float(cosines[i, j]), 1.0)) / DEG
    return (
        f"the planes' normals span only two directions ({planes.names[i]} and {planes.names[j]} are {angle:.1f} degrees from "
        f"parallel), and hardly show errors along the third; place three target planes roughly at right angles{NO_MORE_PLANES}"
    )


def _extents(residuals: Residuals, model: Model) -> tuple[Array, Array]:
    """Return for each of K planes the longest and second-longest extent of its points, ``(K,)`` [m]: standard deviations."""
    measurement = residuals.measurement
    counts, means, factors = measurement.scatter_in_base(residuals.kinematics(model).T_base_sensor)
    on_plane = measurement.target_index == np.arange(len(model.target.normals))[:, None]  # type: ignore[attr-defined]
    totals = on_plane @ counts
    centres = on_plane @ (counts[:, None] * means) / np.maximum(totals, 1.0)[:, None]
    off = np.sqrt(counts)[:, None] * (means - centres[measurement.target_index])
    rows = np.concatenate([off[:, None], factors], axis=1)  # three for each pose
    order = np.argsort(measurement.target_index, kind="stable")
    starts = len(rows[0]) * np.append(0, np.cumsum(on_plane.sum(axis=1)))
    triangular = compress(rows[order].reshape(-1, 3), starts)
    lengths = (
        np.linalg.svd(triangular, compute_uv=False)[:, :2] / np.sqrt(np.maximum(totals - 1, 1.0))[:, None]
    )
    lengths[totals < _LEAST_POINTS] = 0.0, -1.0  # narrower than anything
    return lengths[:, 0], lengths[:, 1]


def _poses_give(count: int) -> str:
    return "1 pose gives" if count == 1 else f"{count} poses give"


def check_determined(identifiability: Identifiability) -> None:
    """Refuse poses that leave geometry undetermined which other poses would determine: a fit that knows no priors needs these.

    Args:
        identifiability: Of the poses, with the directions that are left to priors.

    Raises:
        Undetermined: With the number of directions.
    """
    n = identifiability.n_left_to_priors
    if n:
        raise Undetermined(
            [f"these poses leave {n} direction{'s'[: n - 1]} of the geometry undetermined, which poses that differ in all joints and all over the "
             "workspace would determine"]
        )  # fmt: skip


def check_equations(dataset: Dataset, measurement: Measurement, unknowns: int) -> None:
    """Refuse data with fewer equations than unknowns.

    Args:
        dataset: What was measured.
        measurement: The dataset, as the sensor kind's rows.
        unknowns: Number of parameters that the poses would have to determine.

    Raises:
        TooManyUnknowns: The message says how many poses are missing.
    """
    equations = int(measurement.equations.sum())
    if equations < unknowns:
        more = int(np.ceil((unknowns - equations) / measurement.equations_per_pose))
        raise TooManyUnknowns(
            [f"{_poses_give(dataset.n_poses)} {equations} equations for {unknowns} unknowns"
             f"{', however many points they have' if measurement.scans else ''}: "
             f"measure at least {more} more pose{'s'[: more - 1]}, better twice as many; {_without_them(dataset)}"]
        )  # fmt: skip


def _without_them(dataset: Dataset) -> str:
    """Return what is possible without further poses, and how."""
    what = "undetermined parameters near the data sheet"
    if dataset.robot.tolerance is None:
        return f"or state robot.tolerance, so that 'scalar calibrate' keeps {what}"
    return f"'scalar calibrate' keeps {what}, because robot.tolerance is stated; a diagnosis needs the poses"


def check_setup(
    dataset: Dataset,
    measurement: Measurement,
    guess: Any,
    settings: SufficiencySettings = DEFAULTS.sufficiency,
) -> None:
    """Refuse data that hardly determine even sensor and target, so that a fit may end in a wrong optimum, whatever is known of the arm.

    Args:
        dataset: What was measured.
        measurement: The dataset, as the sensor kind's rows.
        guess: The initial guesses of the planes, or the tracker's frames.
        settings: Thresholds.

    Raises:
        Undetermined: With the numbers of equations and unknowns.
    """
    equations = int(measurement.equations.sum())
    unknowns = (6 if measurement.observes_orientation else 3) + len(guess.vector)
    if equations < settings.equations_for_setup * unknowns:
        raise Undetermined(
            [f"{_poses_give(dataset.n_poses)} {equations} equations, and the places of sensor and {measurement.target_words} alone are "
             f"{unknowns} unknowns: with the maker's tolerance at least {settings.equations_for_setup:g} times as many equations are needed"]
        )  # fmt: skip


class FitFailed(Undetermined):
    """The geometry ended so far from dataset.yaml that the fit says nothing of the planes.

    Args:
        q: ``(N, n)`` [rad; m of a joint that slides], of the poses.
    """

    def __init__(self, q: Array) -> None:
        super().__init__(
            [
                "no fit stays near the arm and the planes that dataset.yaml describes. One wrong sign, zero, length, unit, label or convention does "
                "not explain it, nor do a sign and a zero of one joint: check whether the angles and labels of poses.csv and the measurements belong "
                "together, and then whether several of these are wrong at once" + still_clause(q)
            ]
        )


def check_effects(dataset: Dataset, measurement: Measurement, n_free: int) -> None:
    """Refuse effects whose coefficients, with all other unknowns, are as many as the equations or more: any data could then be fitted.

    Args:
        dataset: What was measured.
        measurement: The dataset, as the sensor kind's rows.
        n_free: Parameters and coefficients that would be estimated.

    Raises:
        TooManyUnknowns: With the numbers of equations and unknowns.
    """
    equations = int(measurement.equations.sum())
    if n_free >= equations:
        raise TooManyUnknowns(
            [f"{_poses_give(dataset.n_poses)} {equations} equations, and with these effects there are {n_free} unknowns or more: "
             "name fewer effects, or measure more poses"]
        )  # fmt: skip
