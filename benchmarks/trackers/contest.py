"""Hand one job to a package, read its answer, and score it at poses that the package has not measured, against the truth without noise."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.trackers.adapters.exchange import Answer, Job, read_answer, write_job
from benchmarks.trackers.environments import Missing, last_line
from benchmarks.trackers.scene import Scene, nominal_positions

ROOT = Path(__file__).parents[2]
ADAPTERS = Path(__file__).parent / "adapters"
TIME_LIMIT = 600.0  # s, for one answer
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Way:
    """A way to calibrate: its line in the table, the adapter that does it, and the package whose environment runs it (None: this one)."""

    title: str
    adapter: Path
    package: str | None


WAYS = (
    Way("scalar.calibrate", ADAPTERS / "fit_scalar.py", None),
    Way("scalar.diagnose", ADAPTERS / "fit_scalar_diagnose.py", None),
    Way("pybotics, distances", ADAPTERS / "fit_pybotics.py", "pybotics"),
    Way("pybotics, components", ADAPTERS / "fit_pybotics_components.py", "pybotics"),
    Way("robotkinecal", ADAPTERS / "fit_robotkinecal.py", "robotkinecal"),
    Way("figaroh, structural", ADAPTERS / "fit_figaroh.py", "figaroh"),
    Way("figaroh, map", ADAPTERS / "fit_figaroh_map.py", "figaroh"),
)


@dataclass(frozen=True)
class Score:
    """Distances between predicted and true positions [m]: root mean square, and the largest."""

    rms: float
    largest: float


@dataclass(frozen=True)
class Outcome:
    """What a package answered, and how far it is from the truth."""

    answer: Answer
    score: Score


def score(predicted: np.ndarray, truth: np.ndarray) -> Score:
    """Return the score of predicted positions ``(M, 3)`` against true ones [m]."""
    distances = np.linalg.norm(np.asarray(predicted, dtype=float) - truth, axis=1)
    return Score(float(np.sqrt(np.mean(distances**2))), float(distances.max()))


def nominal_score(scene: Scene) -> Score:
    """Return the score of the nominal arm in the frame that all packages start from."""
    return score(nominal_positions(scene.job, scene.job.q_test), scene.truth)


def outcome(way: Way, scene: Scene, python: Path | Missing) -> Outcome | Missing:
    """Return what a way makes of a scene.

    Args:
        way: The way.
        scene: Its job is handed over; the truth is not.
        python: The interpreter that runs the adapter, or why there is none.
    """
    if isinstance(python, Missing):
        return python
    with tempfile.TemporaryDirectory() as folder:
        answer = answered(way, scene.job, python, Path(folder))
    if isinstance(answer, Missing):
        return answer
    return Outcome(answer, score(np.array(answer.predicted), scene.truth))


def answered(way: Way, job: Job, python: Path, folder: Path) -> Answer | Missing:
    """Return the answer to a job, or why there is none; the files go to a folder, in which the adapter also works."""
    question, reply = folder / "job.json", folder / "answer.json"
    write_job(question, job)
    # The adapter of scalar runs the code of this checkout; the others see nothing of it.
    paths = {"PYTHONPATH": str(ROOT)} if way.package is None else {}
    environment = (
        {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | ONE_THREAD | paths
    )
    try:
        ended = subprocess.run(
            [str(python), "-W", "ignore", str(way.adapter), str(question), str(reply)],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=TIME_LIMIT,
        )
    except subprocess.TimeoutExpired:
        return Missing(f"no answer after {TIME_LIMIT:.0f} s")
    if ended.returncode:
        return Missing(f"failed: {last_line(ended.stderr)}")
    try:
        return read_answer(reply, len(job.q_test))
    except (OSError, ValueError) as error:
        return Missing(f"no valid answer: {error}")


def own_python() -> Path:
    """Return the interpreter that runs this program."""
    return Path(sys.executable)
