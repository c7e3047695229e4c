"""The workcell in pybullet: an arm and its target planes.

Everything runs in a DIRECT client of its own, with no window, no stepping of time and no shared state;
leaving the `with` block always disconnects it. Four things of the engine are used: forward kinematics, rays,
distances, and torques of gravity.
"""

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from operator import itemgetter
from types import TracebackType

import numpy as np

from scalar.simulation.arm import Arm
from scalar.simulation.body import Body
from scalar.simulation.errors import SimulationError
from scalar.simulation.target_planes import TargetPlane
from scalar.simulation.transforms import Array, rotation_from_quaternion
from scalar.simulation.urdf import urdf_of


@contextmanager
def _silence() -> Iterator[None]:
    """Send what C code prints to nowhere: pybullet announces its build time on import."""
    saved = os.dup(1), os.dup(2)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
    try:
        yield
    finally:
        for number, copy in zip((1, 2), saved, strict=True):
            os.dup2(copy, number)
            os.close(copy)


try:
    with _silence():
        import pybullet
except ImportError as error:
    raise ImportError(
        "simulating needs pybullet, which comes with the extra: pip install 'scalar-calibration[simulation]'"
    ) from error

RAYS_PER_BATCH = 250
"""Rays of one call to pybullet: its answers are two tuples for each ray, which Python's collector of garbage goes through again and again if they are
many; three to four times as fast as one call for all. (A batch of 16,384 is answered with 16,383 results, without a word.)"""
_HIT, _FRACTION = itemgetter(0), itemgetter(2)  # of pybullet's answer for a ray
NOTHING = -1  # pybullet's body id where a ray hits nothing


class World:
    """A pybullet client with target planes and, one at a time, an arm.

    Use as a context manager::

        with World(target_planes) as world:
            world.place_arm(arm, body)
            T_base_sensor = world.sensor_frames(q)
    """

    def __init__(self, target_planes: Sequence[TargetPlane] = ()) -> None:
        self._client: int = pybullet.connect(pybullet.DIRECT)
        if self._client < 0:
            raise SimulationError("pybullet gave no client; too many are open in this process")
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._arm: Arm | None = None
        self._arm_id = NOTHING
        self._asked_torques = False
        self._body: Body | None = None
        self._target_planes: list[TargetPlane] = []
        self.target_plane_ids: list[int] = []
        try:
            self._begin(target_planes)
        except BaseException:
            self.close()
            raise

    def _begin(self, target_planes: Sequence[TargetPlane]) -> None:
        """Add target planes to an empty simulation."""
        # Without this, a URDF is cached by its path, and an arm could come back in place of another.
        pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=self._client)
        self._arm_id, self._asked_torques = NOTHING, False
        self._target_planes, self.target_plane_ids = [], []
        self.set_target_planes(target_planes)

    def __enter__(self) -> "World":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Disconnect; a second call does nothing."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    @property
    def client(self) -> int:
        """Return pybullet's number of this client."""
        return self._client

    @property
    def arm_id(self) -> int:
        """Return pybullet's number of the arm; -1 without one."""
        return self._arm_id

    @property
    def arm(self) -> Arm | None:
        """Return the arm in the workcell; None without one."""
        return self._arm

    def set_target_planes(self, target_planes: Sequence[TargetPlane]) -> None:
        """Replace the target planes by these; one that is there already is kept."""
        standing = list(zip(self._target_planes, self.target_plane_ids, strict=True))
        kept = {
            target_plane_id
            for target_plane, target_plane_id in standing
            if any(target_plane is other for other in target_planes)
        }
        for _, target_plane_id in standing:
            if target_plane_id not in kept:
                pybullet.removeBody(target_plane_id, physicsClientId=self._client)
        ids = []
        for target_plane in target_planes:
            same = [target_plane_id for other, target_plane_id in standing if other is target_plane]
            ids.append(same[0] if same else self._add_target_plane(target_plane))
        self._target_planes, self.target_plane_ids = list(target_planes), ids

    def _add_target_plane(self, target_plane: TargetPlane) -> int:
        """Return the id of a new target plane, made of triangles.

        It is not a box, because pybullet's GEOM_BOX finds the hit by iteration: for about one ray in 270 the range is up
        to 1.3 mm too short, anywhere on the face. With a concave mesh the hit is on the triangle's plane, to rounding. (A
        convex mesh is off by millimetres, and a collision margin would move the face.)
        """
        vertices, triangles = target_plane.solid() if target_plane.mesh is None else target_plane.mesh
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_MESH,
            vertices=vertices.tolist(),
            indices=triangles.ravel().tolist(),
            flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
            physicsClientId=self._client,
        )
        return pybullet.createMultiBody(0, shape, physicsClientId=self._client)

    def place_arm(self, arm: Arm, body: Body | None = None) -> None:
        """Place this arm in the workcell, instead of any other."""
        if self._asked_torques:
            # pybullet keeps the inverse dynamics of a removed arm by its address, where the next one may lie.
            pybullet.resetSimulation(physicsClientId=self._client)
            self._begin(self._target_planes)
        if self._arm_id >= 0:
            pybullet.removeBody(self._arm_id, physicsClientId=self._client)
        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="scalar-")
        path = os.path.join(self._folder.name, "arm.urdf")
        with open(path, "w", encoding="utf-8") as file:
            file.write(urdf_of(arm, body))
        self._arm_id = pybullet.loadURDF(path, useFixedBase=True, physicsClientId=self._client)
        pybullet.setGravity(*arm.gravity.tolist(), physicsClientId=self._client)
        self._arm, self._body = arm, body

    def move(self, q: Sequence[float]) -> None:
        """Set the arm's joints to q (n,) [rad] exactly, without simulating the motion."""
        # One call for all joints: one at a time, pybullet would redo the kinematics at every joint.
        pybullet.resetJointStatesMultiDof(
            self._arm_id, range(len(q)), [[value] for value in q], physicsClientId=self._client
        )

    def sensor_frames(self, q: Array) -> Array:
        """Return T_base_sensor (N, 4, 4) for q (N, n) [rad], by pybullet's forward kinematics."""
        assert self._arm is not None, "no arm has been placed"
        link = self._arm.n + 1
        positions = np.empty((len(q), 3))
        quaternions = np.empty((len(q), 4))
        for k, row in enumerate(np.asarray(q, float).tolist()):
            self.move(row)
            # Items 0 and 1 are double; 4 and 5, the "link frame", are rounded to single.
            state = pybullet.getLinkState(
                self._arm_id, link, computeForwardKinematics=1, physicsClientId=self._client
            )
            positions[k], quaternions[k] = state[0], state[1]
        T = np.zeros((len(q), 4, 4))
        T[:, :3, :3] = rotation_from_quaternion(quaternions)
        T[:, :3, 3] = positions
        T[:, 3, 3] = 1.0
        return T

    def gravity_torques(self, q: Array) -> Array:
        """Return the torque of the arm's weight about each joint at rest, (N, n) [N m], by inverse dynamics.

        It is the torque that the weight applies to the joint, the negative of what the drive has to hold.
        """
        assert self._arm is not None and self._arm.weights is not None, "no arm with weights has been placed"
        still = [0.0] * self._arm.n
        self._asked_torques = True
        torques = [
            pybullet.calculateInverseDynamics(self._arm_id, row, still, still, physicsClientId=self._client)
            for row in np.asarray(q, float).tolist()
        ]
        return -np.array(torques).reshape(-1, self._arm.n)

    def weight_moments(self, q: Array, about: Array) -> Array:
        """Return the moment of the arm's weight about a point (3,) [m] of the base frame, (N, 3) [N m].

        Each link's centre of mass is where pybullet reports it.
        """
        arm = self._arm
        assert arm is not None and arm.weights is not None, "no arm with weights has been placed"
        links = [*range(arm.n), arm.n + 1]
        masses = np.array([*arm.weights.masses, arm.weights.sensor])
        first_moments = np.empty((len(q), 3))
        for k, row in enumerate(np.asarray(q, float).tolist()):
            self.move(row)
            states = pybullet.getLinkStates(
                self._arm_id, links, computeForwardKinematics=1, physicsClientId=self._client
            )
            first_moments[k] = masses @ (np.array([state[0] for state in states]) - about)
        return np.cross(first_moments, arm.gravity)

    def cast(self, starts: Array | list[list[float]], ends: Array) -> tuple[Array, Array]:
        """Return the id of the body that each ray meets first (R,) int, -1 for none, and at which fraction of its length (R,).

        Args:
            starts, ends: (R, 3) [m] in the base frame; starts that rays have in common are converted once if they are lists.

        Raises:
            SimulationError: pybullet returned another number of results than there are rays.
        """
        hit, fraction = np.empty(len(ends), int), np.empty(len(ends))
        for k in range(0, len(ends), RAYS_PER_BATCH):
            batch = slice(k, k + RAYS_PER_BATCH)
            begin = starts[batch]
            asked = begin if isinstance(begin, list) else begin.tolist()
            answers = pybullet.rayTestBatch(asked, ends[batch].tolist(), physicsClientId=self._client)
            if len(answers) != len(asked):
                raise SimulationError(f"{len(asked)} rays were asked and {len(answers)} answered by pybullet")
            hit[batch] = np.fromiter(map(_HIT, answers), int, len(answers))
            fraction[batch] = np.fromiter(map(_FRACTION, answers), float, len(answers))
        return hit, fraction

    def touching(self, q: Sequence[float]) -> str | None:
        """Return what the arm touches at q (n,) [rad]: "target_plane", "itself", or None.

        The base, which may stand on a target plane, is not tested against target planes.
        """
        assert self._body is not None, "an arm without a body touches nothing"
        self.move(q)
        near = self._body.clearance
        for target_plane_id in self.target_plane_ids:
            contacts = pybullet.getClosestPoints(
                self._arm_id, target_plane_id, near, physicsClientId=self._client
            )
            if any(contact[3] >= 0 for contact in contacts):  # item 3: the arm's link
                return "target_plane"
        for first, second in self._body.pairs:
            if pybullet.getClosestPoints(
                self._arm_id, self._arm_id, near, first, second, physicsClientId=self._client
            ):
                return "itself"
        return None

    def refresh(self) -> None:
        """Update the arm's bounding boxes, which `move` does not, so that rays meet the arm where it is now."""
        pybullet.performCollisionDetection(physicsClientId=self._client)
