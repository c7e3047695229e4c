"""How far a fit is from what the machine could do: its bytes read once, and its operations, at the rates that are measured in the same run.

Counted is what the fit of ``scalar`` needs, not what an idle instruction adds. Bytes: two coordinates of every point and the joint angles of every
pose, 8 bytes each, read once from memory. Operations: additions, multiplications, divisions, roots, sines and cosines of the formulas, each
as one; derivatives that are zero, as those by other planes, are not counted. The limit is the longer of both times; no program
reaches it, because operations depend on one another and not all of them can be fused and done eight at a time.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.contestants import Contest
from benchmarks.scenes import paper_scene, repeated
from benchmarks.timing import interleaved
from scalar.units import MS

SOURCE = Path(__file__).parent / "solvers" / "machine.c"
POINT = 26
"""Operations a point: its weight 11, ``w [1, x, z]`` 3, six sums of products 12."""
JOINT, JOINT_DERIVATIVES = 102, 94
"""Operations a joint of a pose: its frame; the derivatives by its five parameters, components of cross products."""
POSE = 160
"""Operations a pose: flange 63, the sensor's place and two axes 48, the contact 16, two cross products 18, the rows 15."""
SENSOR_DERIVATIVES, PLANE_DERIVATIVES = 90, 30
"""Operations of the derivatives of a pose by the sensor and by its plane."""
ROWS = 3
_REPEATS, _LARGE = 5, 100


@dataclass(frozen=True)
class Need:
    """What a fit needs: bytes read once, and operations."""

    bytes: float
    operations: float


@dataclass(frozen=True)
class Machine:
    """What one core does at best, and how that was measured."""

    bytes_per_second: float
    operations_per_second: float
    measured_by: str

    def limit(self, need: Need) -> float:
        """Return the least time in which a fit could be done [s]."""
        return max(need.bytes / self.bytes_per_second, need.operations / self.operations_per_second)


def needed(poses: int, joints: int, points: int, inner: int, planes: int, evaluations: int) -> Need:
    """Return what one fit with standard errors needs.

    Args:
        poses: Number of poses.
        joints: Number of joints.
        points: Number of points of all scans.
        inner: Number of free coordinates of arm and sensor; three of every plane come on top.
        planes: Number of planes.
        evaluations: Number of evaluations of residual and Jacobian.
    """
    own, all_free = inner + 3, inner + 3 * planes
    rows = ROWS * (5 * own + own * (own + 1) + 2 * own)  # factors times derivatives, J'J of one half, J'r
    pose = POSE + (JOINT + JOINT_DERIVATIVES) * joints + SENSOR_DERIVATIVES + PLANE_DERIVATIVES + rows
    solution = all_free**3 / 3 + 2 * all_free**2
    operations = POINT * points + evaluations * (poses * pose + solution) + all_free**3
    return Need(8.0 * (2 * points + joints * poses), operations)


def machine() -> Machine:
    """Return the rates of this machine, by a compiled kernel, or by NumPy where there is no C compiler."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        return _machine_by_numpy()
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "machine"
        command = [compiler, "-O3", "-march=native", "-ffp-contract=fast", str(SOURCE), "-o", str(program)]
        if subprocess.run(command, capture_output=True).returncode:
            return _machine_by_numpy()
        read, arithmetic = subprocess.run(
            [program], check=True, capture_output=True, text=True
        ).stdout.split()
    return Machine(float(read), float(arithmetic), "a compiled kernel")


def _machine_by_numpy() -> Machine:
    """Return the rates at which NumPy sums 128 MB, and multiplies matrices."""
    data, n = np.ones(16 * 1024**2), 500
    A = np.ones((n, n))
    times = interleaved({"read": data.sum, "multiply": lambda: A @ A}, _REPEATS)
    return Machine(
        data.nbytes / times["read"].least, 2 * n**3 / times["multiply"].least, "NumPy: no C compiler"
    )


def limits(rounds: int) -> None:
    """Print the rates of the machine, and how many times slower than its limit one fit is, for 120 and for 12,000 poses."""
    rates = machine()
    print(
        f"one core, by {rates.measured_by}: {rates.bytes_per_second / 1e9:.1f} GB/s read,"
        f" {rates.operations_per_second / 1e9:.1f} billion operations a second"
    )
    print(
        f"{'poses':>8s}{'read [kB]':>12s}{'million operations':>20s}{'limit [ms]':>12s}{'fit [ms]':>10s}{'slower':>8s}"
    )
    scene = paper_scene()
    for contest in (Contest(scene), Contest(repeated(scene, _LARGE))):
        times = interleaved({"": contest.proposed}, rounds if contest.dataset.n_poses == scene.n_poses else 3)
        need = need_of(contest, contest.proposed().evaluations)
        limit, taken = rates.limit(need), times[""].median
        print(
            f"{contest.dataset.n_poses:8d}{need.bytes / 1e3:12.0f}{need.operations / 1e6:20.2f}{limit / MS:12.3f}"
            f"{taken / MS:10.2f}{taken / limit:8.0f}"
        )
    print()


def need_of(contest: Contest, evaluations: int) -> Need:
    """Return what the fit of a contest needs."""
    n_poses, n = contest.dataset.q.shape
    inner = int(np.sum(contest.free < 5 * n + 6))
    planes = len(contest.model.target.distances)
    return needed(n_poses, n, len(contest.x), inner, planes, evaluations)
