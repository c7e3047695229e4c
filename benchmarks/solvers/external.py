"""Programs of other solvers: built where a compiler and the library are there, started, asked for fits; what is missing is said in a word."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.contestants import Contest
from benchmarks.solvers.problem_file import PlaneProblemFile
from scalar.estimation.least_squares import TOLERANCE

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "benchmarks" / "ceres"
BUILT = ROOT / "benchmarks" / "built"  # compiled programs, which git ignores
SOLVERS_PYTHON = ROOT / ".venv-solvers" / "bin" / "python"  # `make bench-solvers` makes it
EIGEN = "/usr/include/eigen3"  # where Debian's libeigen3-dev has its headers
CERES_WAYS, JAX_WAYS = ("point", "pose", "compressed"), ("points", "compressed")


class MissingSolverError(Exception):
    """A solver cannot be used here; the text says why in a few words."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What a program found in one fit.

    Attributes:
        seconds: Processor time of the fit, from the points in memory to the standard errors, as the program measured it.
        evaluations: Evaluations of the residuals.
        peak_bytes: Peak memory of the program so far.
        vector: ``(P,)``, all coordinates at the optimum [m, rad].
        std: ``(F,)``, standard errors of the free coordinates.
        compile_seconds: Processor time that compiling took when this fit was first asked for; 0 for a program that is compiled beforehand.
    """

    seconds: float
    evaluations: int
    peak_bytes: int
    vector: np.ndarray
    std: np.ndarray
    compile_seconds: float = 0.0


class Program:
    """A running program that answers each word on its standard input with a line of JSON."""

    def __init__(self, command: list[str], cwd: Path = ROOT) -> None:
        self._ended: str | None = None  # why, if it did
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=cwd
        )

    def __enter__(self) -> Program:
        """Return the program."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the program, whatever it does."""
        self._process.kill()
        self._process.communicate()

    def fit(self, way: str) -> Answer:
        """Return the answer to a word; MissingSolverError with the program's last line if it ended instead."""
        process = self._process
        assert process.stdin and process.stdout and process.stderr
        try:
            process.stdin.write(f"{way}\n")
            process.stdin.flush()
            line = process.stdout.readline()
        except BrokenPipeError:
            line = ""
        if not line:
            if self._ended is None:
                said = process.stderr.read().strip().splitlines() or [f"exit code {process.wait()}"]
                self._ended = f"it ended: {said[-1]}"
            raise MissingSolverError(self._ended)
        try:
            found = json.loads(line)
        except ValueError:  # as after a fit that diverged: C++ writes nan where JSON has no such word
            raise MissingSolverError(f"its answer cannot be read: {line.strip()[:80]}") from None
        return Answer(
            found["seconds"],
            found["evaluations"],
            found["peak_bytes"],
            np.array(found["vector"]),
            np.array(found["std"]),
            found.get("compile_seconds", 0.0),
        )


def problem_of(contest: Contest) -> PlaneProblemFile:
    """Return the problem of a contest, with the weights of its points at the start; all coordinates of planes have to be free."""
    model, robot, target = contest.model, contest.model.robot, contest.model.target
    inner = robot.geometry.size + 6
    if not np.array_equal(contest.free[contest.free >= inner], np.arange(inner, len(model.vector))):
        raise ValueError("the other solvers are written for planes of which all coordinates are free")
    return PlaneProblemFile(
        starts=contest.dataset.starts,
        plane=contest.prepared.residuals.measurement.target_index,
        free=contest.free[contest.free < inner],
        q=contest.dataset.q,
        x=contest.x,
        z=contest.z,
        w=contest.weights,
        start=model.vector,
        T_base_0=robot.T_base_0,
        T_n_flange=robot.T_n_flange,
        R_sensor=model.reference_rotation,
        normals=target.reference_normals,
        tangents=target.tangents,
    )


def ceres_command(problem: PlaneProblemFile, path: Path, *, build: bool = True) -> list[str]:
    """Return the command that fits the problem in a file by Ceres.

    Args:
        problem: Its numbers of joints and of free coordinates are fixed in the program.
        path: Where the problem was written.
        build: Whether to build a program that is not there yet, which takes some ten seconds.
    """
    sources = sorted(SOURCES.iterdir())
    options = [f"-DJOINTS={problem.q.shape[1]}", f"-DFREE={len(problem.free)}", f"-DTOLERANCE={TOLERANCE}"]
    read = hashlib.sha256(" ".join(options).encode() + b"".join(each.read_bytes() for each in sources))
    program = BUILT / f"fit_planes_{read.hexdigest()[:16]}"
    if not program.exists():
        if not build:
            raise MissingSolverError("not built (make bench-solvers)")
        _build(program, options)
    return [str(program), str(path)]


def _build(program: Path, options: list[str]) -> None:
    if shutil.which("g++") is None:
        raise MissingSolverError("g++ is missing")
    includes = ["-isystem", EIGEN]
    test = subprocess.run(
        ["g++", *includes, "-E", "-x", "c++", "-"],
        input="#include <ceres/ceres.h>\n",
        text=True,
        capture_output=True,
    )
    if test.returncode:
        raise MissingSolverError("Ceres is missing (Debian: libceres-dev)")
    # 16: the alignment of Eigen's memory with which Debian's library was compiled, whatever this processor prefers.
    flags = ["-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-DEIGEN_MAX_ALIGN_BYTES=16", *options]
    BUILT.mkdir(exist_ok=True)
    partial = program.with_suffix(f".{os.getpid()}")
    source = str(SOURCES / "fit_planes.cpp")
    run = subprocess.run(
        ["g++", *flags, *includes, source, "-o", str(partial), "-lceres", "-lglog"],
        text=True,
        capture_output=True,
    )
    if run.returncode:
        errors = [line for line in run.stderr.splitlines() if "error" in line] or ["g++ failed"]
        raise MissingSolverError(f"it does not compile: {errors[0]}")
    partial.rename(program)


def jax_command(path: Path, python: Path = SOLVERS_PYTHON) -> list[str]:
    """Return the command that fits the problem in a file by JAX, in its own environment."""
    if not python.exists():
        raise MissingSolverError("JAX is missing (make bench-solvers)")
    return [str(python), "-m", "benchmarks.solvers.jax_fit", str(path)]
