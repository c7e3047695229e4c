"""A target plane: the place and the size of its face, and the solid that pybullet gets.

The face is the plane n . p = d. The solid lies behind the face as seen from the arm's shoulder, so that the arm looks at
the face whichever sign the normal has.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.simulation.transforms import Array

SOLID_TRIANGLES = (
    *((0, 1, 3), (0, 3, 2)),  # the face
    *((4, 6, 7), (4, 7, 5)),  # the back
    *((0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)),  # the edges
    *((0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
)
ON_FACE = 1e-9  # m; a shoulder nearer to the plane than this is on neither side


@dataclass(frozen=True, eq=False)
class TargetPlane:
    """A rectangular target plane.

    Attributes:
        name: of the plane, as in the dataset.
        normal: (3,) unit, base frame, as the user wrote it.
        distance: n . p on the face [m].
        centre: (3,) [m] middle of the face.
        axes: (3, 3), columns u, v in the face and w out of it, towards the arm.
        size: (2,) [m] along u and v.
        thickness: [m], behind the face.
        mesh: None for a flat target plane; else vertices (V, 3) [m] in the base frame and triangles (F, 3).
    """

    name: str
    normal: Array
    distance: float
    centre: Array
    axes: Array
    size: Array
    thickness: float
    mesh: tuple[Array, Array] | None = None

    def solid(self) -> tuple[Array, Array]:
        """Return vertices (8, 3) [m] and triangles (12, 3) of the flat target plane, turned outwards."""
        corners = np.array([[u, v, w] for w in (0.0, -1.0) for v in (-0.5, 0.5) for u in (-0.5, 0.5)])
        vertices = self.centre + (corners * [*self.size, self.thickness]) @ self.axes.T
        return vertices, np.array(SOLID_TRIANGLES)

    def moved(self, **changes: Any) -> "TargetPlane":
        """Return the target plane with some attributes replaced, for effects that bend or move it."""
        return replace(self, **changes)


def target_plane_from_mapping(plane: Mapping[str, Any], shoulder: Array) -> TargetPlane:
    """Return the target plane of an entry of the config's `planes`.

    For an upright wall u is level and v points up; for a floor u is along the base frame's x and v along its y. The
    given centre is moved onto the plane along its normal; without one, the centre is the point of the plane nearest to
    the base's origin.

    Args:
        plane: name, normal (3,), distance_m, centre_m (3,) or None, size_m (2,), thickness_m.
        shoulder: (3,) [m] a point on the side from which the arm looks.
    """
    normal = np.array(plane["normal"], float)
    length = np.linalg.norm(normal)
    normal = normal / length
    distance = float(plane["distance_m"])
    centre = np.zeros(3) if plane["centre_m"] is None else np.array(plane["centre_m"], float)
    centre = centre + (distance - normal @ centre) * normal
    height = normal @ shoulder - distance
    w = -normal if height < -ON_FACE else normal
    reference = np.array([0.0, 0.0, 1.0]) if abs(w[2]) < np.sqrt(0.5) else np.array([0.0, 1.0, 0.0])
    v = reference - (reference @ w) * w
    v = v / np.linalg.norm(v)
    return TargetPlane(
        name=plane["name"],
        normal=normal,
        distance=distance,
        centre=centre,
        axes=np.column_stack([np.cross(v, w), v, w]),
        size=np.array(plane["size_m"], float),
        thickness=float(plane["thickness_m"]),
    )
