"""Whether data can determine a model at all: refused here with what would fix it, before or after a first look at the geometry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.errors import Fault, InvalidInput, Undetermined
from scalar.identifiability import Identifiability
from scalar.model import Model
from scalar.planes import Planes
from scalar.residuals import Residuals
from scalar.sensors import Measurement
from scalar.sensors.line_laser import LineLaser
from scalar.units import DEG

if TYPE_CHECKING:
    from scalar.dataset import Dataset

LEAST_PLANES = 3
LEAST_SPAN = np.sin(10 * DEG)  # of three normals: the smallest singular value, 1 for a right-angled corner
FARTHEST_GUESS = 60 * DEG  # a rough normal may be this far off the plane that the points lie on
LEAST_WIDTH = 1e-3  # of a plane's longest extent: narrower than that its points lie on a line


def check_data(dataset: Dataset, measurement: Measurement) -> None:
    """Refuse data that are too few, by counting alone.

    Raises:
        Undetermined: Fewer than three planes are measured, or there are hardly any poses.
    """
    reasons = []
    if dataset.sensor.kind != "tracker":
        seen = sorted({dataset.planes[k].name for k in dataset.plane_index})
        if len(seen) < LEAST_PLANES:
            reasons.append(
                f"only {len(seen)} of the planes {', '.join(p.name for p in dataset.planes)} "
                f"{'is' if len(seen) == 1 else 'are'} measured, and at least three that are not parallel are needed: "
                "with fewer, robot and planes can move together unseen; scan a third plane"
            )
    if dataset.n_poses * measurement.equations_per_pose < dataset.robot.n_joints:
        reasons.append(f"{dataset.n_poses} poses cannot determine a robot of {dataset.robot.n_joints} joints; measure more")
    if reasons:
        raise Undetermined(reasons)


def check_geometry(dataset: Dataset, residuals: Residuals, model: Model, guess: Any) -> None:
    """Refuse planes that the points contradict, that are parallel, or that are scanned on one line only.

    Args:
        dataset: Gives the names.
        residuals: Of the dataset.
        model: With sensor and planes as a first fit found them.
        guess: The rough planes.

    Raises:
        InvalidInput: A rough plane is far from where the points lie: a wrong label or a wrong normal.
        Undetermined: The planes do not span space, or a plane is seen on a line only.
    """
    planes = model.target
    if not isinstance(planes, Planes):
        return
    cosine = np.abs(np.sum(planes.normals * guess.normals, axis=1))
    faults = [
        Fault(
            "dataset.yaml",
            f"the points said to lie on it lie on a plane that is {np.arccos(min(c, 1.0)) / DEG:.0f} degrees from this rough "
            "normal: correct the normal, or the plane's name in poses.csv",
            None,
            f"planes.{name}.normal",
        )
        for name, c in zip(planes.names, cosine, strict=True)
        if c < np.cos(FARTHEST_GUESS)
    ]
    if faults:
        raise InvalidInput(faults)
    reasons = [
        f"all points on plane '{name}' lie on a line, so its tilt about that line cannot be seen: "
        "scan it in other places and directions"
        for name, width in zip(planes.names, _relative_widths(residuals, model), strict=True)
        if width < LEAST_WIDTH
    ]
    span = float(np.linalg.svd(planes.normals, compute_uv=False)[-1]) if len(planes.normals) >= LEAST_PLANES else 0.0
    if span < LEAST_SPAN and isinstance(residuals.measurement, LineLaser):
        reasons.append(_parallel_planes(planes))
    if reasons:
        raise Undetermined(reasons)


def _parallel_planes(planes: Planes) -> str:
    cosines = np.abs(planes.normals @ planes.normals.T) - np.eye(len(planes.normals))
    i, j = np.unravel_index(int(np.argmax(cosines)), cosines.shape)
    angle = np.arccos(min(float(cosines[i, j]), 1.0)) / DEG
    return (
        f"the planes' normals span only two directions ({planes.names[i]} and {planes.names[j]} are {angle:.1f} degrees from "
        "parallel): motion along the third cannot be seen; place three plates roughly at right angles"
    )


def _relative_widths(residuals: Residuals, model: Model) -> list[float]:
    """Return for each plane the second-longest extent of its points over the longest."""
    measurement = residuals.measurement
    T = residuals.kinematics(model).T_base_sensor
    widths = []
    for k in range(len(model.target.normals)):  # type: ignore[attr-defined]
        mine = measurement.target_index == k
        if isinstance(measurement, LineLaser):
            counts = np.diff(measurement.starts)
            use = np.repeat(mine, counts)
            x, z = measurement.points[use].T
            frames = np.repeat(T[mine], counts[mine], axis=0)
            points = frames[:, :3, 0] * x[:, None] + frames[:, :3, 2] * z[:, None] + frames[:, :3, 3]
        else:
            points = T[mine, :3, 3]
        if len(points) < LEAST_PLANES:
            widths.append(0.0)
            continue
        extent = np.linalg.svd(np.cov(points.T), compute_uv=False)
        widths.append(float(np.sqrt(max(extent[1], 0.0) / max(extent[0], 1e-300))))
    return widths


def check_parameters(
    dataset: Dataset, residuals: Residuals, model: Model, identifiability: Identifiability, n_free: int
) -> None:
    """Refuse data with fewer equations than unknowns, or that leave unseen what no held joint explains.

    Raises:
        Undetermined: With what is missing.
    """
    measurement = residuals.measurement
    if isinstance(measurement, LineLaser):
        equations = int(np.minimum(np.diff(measurement.starts), measurement.equations_per_pose).sum())
    else:
        equations = dataset.n_poses * measurement.equations_per_pose
    needed = n_free + _excess(identifiability)
    if equations < needed:
        more = int(np.ceil((needed - equations) / measurement.equations_per_pose))
        raise Undetermined(
            [f"{dataset.n_poses} poses give {equations} equations for {needed} unknowns, however many points they have: "
             f"measure at least {more} more poses, better twice as many"]
        )  # fmt: skip
    unseen = [h for h in identifiability.held if h.cause == "poses"]
    if unseen:
        raise Undetermined(
            [f"these poses cannot show {h.name}: {h.reason}; measure more poses that differ in all joints and all over the "
             "planes" for h in unseen]
        )  # fmt: skip


def _excess(identifiability: Identifiability) -> int:
    """Return how many held parameters these poses alone hide: unknowns that are held only for want of data."""
    return sum(h.cause == "poses" for h in identifiability.held)
