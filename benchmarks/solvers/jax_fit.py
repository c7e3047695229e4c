"""Fit arm, sensor and planes to scans of planes by JAX: ``python -m benchmarks.solvers.jax_fit PROBLEM`` in an environment that has JAX.

Each line of the standard input is one word: ``points`` (every point a residual) or ``compressed`` (three rows for every scan). Each is answered
by a line of JSON with the names that ``benchmarks/ceres/fit_planes.cpp`` gives, and ``compile_seconds``, the processor time of tracing and
compiling [s], which happens once for each word and is no part of ``seconds``. The whole fit (compression, forward-mode Jacobian,
Levenberg-Marquardt, standard errors) is one compiled function in double precision on one thread.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["JAX_PLATFORMS"] = "cpu"

import jax  # pyright: ignore[reportMissingImports]
import jax.numpy as jnp  # pyright: ignore[reportMissingImports]
import numpy as np

from benchmarks.peak_memory import peak_bytes
from benchmarks.solvers.problem_file import PlaneProblemFile

jax.config.update("jax_enable_x64", True)

TOLERANCE = 1e-10  # relative, on the cost, as for the others
MOST_STEPS = 200
FIRST_DAMPING = 1e-4  # relative to the diagonal of the normal equations: where Ceres begins


def arrays_of(problem: PlaneProblemFile) -> dict[str, np.ndarray]:
    """Return the arrays of a problem, its scans as ``(N, M, 3)`` of ``w [1, x, z]``; a shorter scan is filled with zeros."""
    counts = np.diff(problem.starts)
    scans = np.zeros((len(counts), int(counts.max()), 3))
    inside = np.arange(scans.shape[1]) < counts[:, None]
    scans[inside] = problem.w[:, None] * np.column_stack([np.ones_like(problem.x), problem.x, problem.z])
    names = ("plane", "q", "start", "T_base_0", "T_n_flange", "R_sensor", "normals", "tangents")
    inner = 5 * problem.q.shape[1] + 6
    coordinates = np.concatenate([problem.free, np.arange(inner, len(problem.start))])
    return {name: getattr(problem, name) for name in names} | {"scans": scans, "coordinates": coordinates}


def rotation(r: Any) -> Any:
    """Return the rotation matrix of a rotation vector ``(3,)``; at zero, where the formula has no derivative, by its series."""
    squared = r @ r
    small = squared < 1e-8
    angle = jnp.sqrt(jnp.where(small, 1.0, squared))
    first = jnp.where(small, 1.0 - squared / 6.0, jnp.sin(angle) / angle)
    second = jnp.where(small, 0.5 - squared / 24.0, (1.0 - jnp.cos(angle)) / angle**2)
    W = jnp.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])
    return jnp.eye(3) + first * W + second * (W @ W)


def tilts(alpha: Any, beta: Any) -> Any:
    """Return ``Rx(alpha) Ry(beta)`` of every joint ``(n, 3, 3)``."""
    ca, sa, cb, sb, none = jnp.cos(alpha), jnp.sin(alpha), jnp.cos(beta), jnp.sin(beta), jnp.zeros_like(alpha)
    rows = [[cb, none, sb], [sa * sb, ca, -sa * cb], [-ca * sb, sa, ca * cb]]
    return jnp.transpose(jnp.stack([jnp.stack(row) for row in rows]), (2, 0, 1))


def contacts(vector: Any, given: dict[str, Any]) -> Any:
    """Return ``(n.o - d, n.X, n.Z)`` of every pose ``(N, 3)``: n, d of its plane, o, X, Z of the sensor; planes are carried through the joints.

    All poses are one array throughout: four times faster than one pose, mapped over all.
    """
    n = given["q"].shape[1]
    a, alpha, d_joint, theta, beta = vector[: 5 * n].reshape(5, n)
    sensor = vector[5 * n : 5 * n + 6]
    u, v, distances = vector[5 * n + 6 :].reshape(-1, 3).T
    tangents = given["tangents"]
    normals = given["normals"] + u[:, None] * tangents[:, 0] + v[:, None] * tangents[:, 1]
    normals = normals / jnp.linalg.norm(normals, axis=1, keepdims=True)
    base, flange = given["T_base_0"], given["T_n_flange"]
    d = (distances - normals @ base[:3, 3])[given["plane"]]
    seen = (normals @ base[:3, :3])[given["plane"]]
    tilted, angles = tilts(alpha, beta), given["q"] + theta
    c, s = jnp.cos(angles), jnp.sin(angles)
    for i in range(n):
        d = d - seen[:, 0] * a[i]
        x, y, z = (seen @ tilted[i]).T
        seen = jnp.stack([c[:, i] * x + s[:, i] * y, c[:, i] * y - s[:, i] * x, z], axis=1)
        d = d - z * d_joint[i]
    d = d - seen @ flange[:3, 3]
    seen = seen @ flange[:3, :3]
    axes = seen @ (rotation(sensor[3:]) @ given["R_sensor"])
    return jnp.stack([seen @ sensor[:3] - d, axes[:, 0], axes[:, 2]], axis=1)


def fit(compressed: bool, given: dict[str, Any]) -> tuple[Any, Any, Any]:
    """Return the coordinates at the optimum, the standard errors of the free ones, and the number of evaluations."""
    rows = jnp.linalg.qr(given["scans"], mode="r") if compressed else given["scans"]
    start, coordinates = given["start"], given["coordinates"]

    def residual(x: Any) -> tuple[Any, Any]:
        vector = start.at[coordinates].set(x)
        r = jnp.einsum("nmk,nk->nm", rows, contacts(vector, given)).ravel()
        return r, r

    def linearised(x: Any) -> tuple[Any, Any, Any]:
        J, r = jax.jacfwd(residual, has_aux=True)(x)
        return r @ r, J.T @ J, J.T @ r

    def goes_on(state: tuple[Any, ...]) -> Any:
        return ~state[-1] & (state[-2] < MOST_STEPS)

    def step(state: tuple[Any, ...]) -> tuple[Any, ...]:
        x, damping, cost, gram, gradient, evaluations, _ = state
        damped = gram + damping * jnp.diag(jnp.diag(gram))
        move = -jnp.linalg.solve(damped, gradient)
        there = x + move
        new_cost, new_gram, new_gradient = linearised(there)
        better = new_cost <= cost
        promised = -(2 * gradient + gram @ move) @ move
        ended = (jnp.abs(cost - new_cost) <= TOLERANCE * cost) & (promised <= TOLERANCE * cost)
        damping = jnp.where(better, damping / 3, damping * 4)
        chosen = [
            jnp.where(better, new, old)
            for new, old in ((there, x), (new_cost, cost), (new_gram, gram), (new_gradient, gradient))
        ]
        return chosen[0], damping, *chosen[1:], evaluations + 1, ended

    x = start[coordinates]
    state = x, jnp.asarray(FIRST_DAMPING), *linearised(x), jnp.asarray(1), jnp.asarray(False)
    x, _, _, gram, _, evaluations, _ = jax.lax.while_loop(goes_on, step, state)
    return start.at[coordinates].set(x), jnp.sqrt(jnp.diag(jnp.linalg.inv(gram))), evaluations


def compiled(way: str, given: dict[str, Any]) -> tuple[Callable[..., Any], float]:
    """Return the compiled fit of a way, and the processor time that compiling took [s]."""
    start = time.process_time()
    program = jax.jit(partial(fit, way == "compressed")).lower(given).compile()
    return program, time.process_time() - start


def answer(program: Callable[..., Any], given: dict[str, Any], compile_seconds: float) -> dict[str, Any]:
    """Return the answer of one fit, ready for JSON."""
    start = time.process_time()
    vector, std, evaluations = jax.block_until_ready(program(given))
    seconds = time.process_time() - start
    return {
        "seconds": seconds,
        "compile_seconds": compile_seconds,
        "evaluations": int(evaluations),
        "peak_bytes": peak_bytes(),
        "vector": np.asarray(vector).tolist(),
        "std": np.asarray(std).tolist(),
    }


def main() -> None:
    """Answer one line after another."""
    given = {
        name: jnp.asarray(each) for name, each in arrays_of(PlaneProblemFile.read(Path(sys.argv[1]))).items()
    }
    programs: dict[str, tuple[Callable[..., Any], float]] = {}
    for line in sys.stdin:
        way = line.strip()
        if way not in programs:
            programs[way] = compiled(way, given)
        program, seconds = programs[way]
        print(json.dumps(answer(program, given, seconds)), flush=True)


if __name__ == "__main__":
    main()
