"""Planes as the target of a sensor: which pose measures which plane, their fit in closed form, and how they are saved."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors.protocol import Measurement
from scalar.sensors.target import Target

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


_TARGETS_OF: WeakKeyDictionary[Dataset, tuple[Array, Planes]] = WeakKeyDictionary()


class OnPlanes(Measurement):
    """The part of the protocol that is the same for all kinds of sensor that measure planes."""

    target_words = "planes"

    def initial_target(self, dataset: Dataset) -> Planes:
        """Return the planes at their initial guesses, one for each plane in each session in which it is measured."""
        return plane_targets(dataset)[1]

    @classmethod
    def declared_target(cls, dataset: Dataset) -> Planes:
        """Return all planes that the dataset declares, whether or not poses measure them."""
        planes = dataset.planes
        return Planes.at(
            [p.name for p in planes], np.array([p.normal for p in planes]), [p.distance for p in planes]
        )

    @classmethod
    def target_to_mapping(cls, target: Target, std: Mapping[str, float]) -> dict[str, Any]:
        """Return the planes, each with its standard errors [rad and m] and its reference normal, about which its tangent coordinates are taken."""
        assert isinstance(target, Planes)
        planes = [
            {
                "name": name,
                "normal": [float(x) for x in normal],
                "distance": float(distance),
                "normal_std_rad": [std.get(f"normal_{name}_u"), std.get(f"normal_{name}_v")],
                "distance_std_m": std.get(f"distance_{name}"),
                "reference_normal": [float(x) for x in reference],
            }
            for name, normal, distance, reference in zip(
                target.names, target.normals, target.distances, target.reference_normals, strict=True
            )
        ]
        return {"planes": planes}

    @classmethod
    def target_from_mapping(cls, mapping: Mapping[str, Any]) -> Planes:
        """Return the planes of ``target_to_mapping``."""
        planes = mapping["planes"]
        names, distances = [p["name"] for p in planes], [p["distance"] for p in planes]
        guess = Planes.at(names, np.array([p["reference_normal"] for p in planes]), distances)
        return Planes.at(names, np.array([p["normal"] for p in planes]), distances).expressed_about(guess)


def plane_targets(dataset: Dataset) -> tuple[Array, Planes]:
    """Return which target each pose measures ``(N,)`` and the targets: every plane that is measured, once for each session."""
    if dataset not in _TARGETS_OF:
        _TARGETS_OF[dataset] = _plane_targets(dataset)
    return _TARGETS_OF[dataset]


def _plane_targets(dataset: Dataset) -> tuple[Array, Planes]:
    """Return what ``plane_targets`` returns, computed anew."""
    plane = dataset.plane_index
    session, count = dataset.session, max(len(dataset.planes), 1)
    codes, index = np.unique(plane if session is None else session * count + plane, return_inverse=True)
    pairs = [divmod(code, count) for code in codes.tolist()]
    several = session is not None and len(np.unique(session)) > 1
    names = [dataset.planes[k].name + (f"@{s + 1}" if several else "") for s, k in pairs]
    normals = np.array([dataset.planes[k].normal for _, k in pairs])
    distances = np.array([dataset.planes[k].distance for _, k in pairs])
    return index.reshape(-1), Planes.at(names, normals, distances)


def fit_planes(target: Planes, index: Array, counts: Array, first: Array, second: Array) -> Planes:
    """Return the planes of least squared distance to points that are given by their moments in the base frame, for each pose.

    Args:
        target: The previous planes. They give the names and the signs of the normals; a plane with fewer than three points keeps its values.
        index: ``(N,)``, which plane each pose measures.
        counts: ``(N,)``, number of points of each pose.
        first: ``(N, 3)`` [m], their sum.
        second: ``(N, 3, 3)`` [m^2], the sum of their products.
    """
    on_plane = (index == np.arange(len(target.normals))[:, None]).astype(
        float
    )  # (K, N), 1 if the pose measures the plane
    totals = on_plane @ counts
    enough = totals >= 3
    divisor = np.where(enough, totals, 1.0)[:, None]
    means = on_plane @ first / divisor
    scatter = (on_plane @ second.reshape(len(second), 9) / divisor).reshape(-1, 3, 3) - means[
        :, :, None
    ] * means[:, None, :]
    found = np.linalg.eigh(scatter)[1][:, :, 0]
    found *= np.where(np.sum(found * target.normals, axis=1) >= 0, 1.0, -1.0)[:, None]
    normals = np.where(enough[:, None], found, target.normals)
    distances = np.where(enough, np.sum(normals * means, axis=1), target.distances)
    return Planes.at(target.names, normals, distances)


def moments_in_base(R: Array, T_base_sensor: Array) -> tuple[Array, Array, Array]:
    """Return number ``(N,)``, sum ``(N, 3)`` [m] and sum of products ``(N, 3, 3)`` [m^2] of the points of N scans, in the base frame.

    Args:
        R: ``(N, 3, 3)``, triangular factors of ``[1, x, z]``, with equal weights of all points; ``R^T R`` holds the sums, and R has zeros below
            its diagonal.
        T_base_sensor: ``(N, 4, 4)``.
    """
    rows = R @ np.swapaxes(T_base_sensor[:, :3, [3, 0, 2]], 1, 2)  # origin, X and Z
    root = R[:, 0, 0]
    return root**2, root[:, None] * rows[:, 0], np.swapaxes(rows, 1, 2) @ rows


def scatter_in_base(R: Array, T_base_sensor: Array) -> tuple[Array, Array, Array]:
    """Return the number ``(N,)`` and mean ``(N, 3)`` [m] of the points of N scans in the base frame, and factors F of their scatter.

    F is ``(N, 2, 3)`` [m], and ``F^T F`` the sum of products of the points about their mean. Arguments as for ``moments_in_base``.
    """
    root = R[:, 0, 0]
    X, Z, o = (T_base_sensor[:, :3, k] for k in (0, 2, 3))
    mean = o + (R[:, 0, 1:2] * X + R[:, 0, 2:3] * Z) / root[:, None]
    return np.rint(root**2), mean, R[:, 1:, 1:] @ np.stack([X, Z], axis=1)
