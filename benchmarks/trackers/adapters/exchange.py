"""What the benchmark and the adapters of the packages pass to one another: a job and an answer, two JSON files.

Adapters run with the interpreter of another environment, so this module needs NumPy alone. A job holds what a user of any of the packages
would have: the maker's table of the arm, the measured positions of one reflector, and joint angles at which a prediction is wanted. It never
holds the truth. Lengths are in metres and angles in radians.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

KINDS = ("alpha", "a", "theta", "d")
"""Columns of a table of modified DH parameters: a joint multiplies by Rx(alpha) Tx(a) Rz(q + theta) Tz(d) from the right."""
FITS = 2
"""How often an adapter fits from the beginning: a first time, and once more when everything has been loaded and used."""


@dataclass(frozen=True, eq=False)
class Job:
    """One calibration task.

    Attributes:
        dh: ``(n, 4)``, the maker's parameters in the order of ``KINDS`` [rad, m, rad, m].
        limits: ``(n, 2)``, limits of the joints [rad].
        reflector: ``(3,)``, nominal place of the reflector on the flange [m].
        T_tracker_base: ``(4, 4)``, start of the base's frame in the tracker's, for packages that have no estimate of their own.
        noise: Standard deviation of a measured coordinate [m].
        q: ``(N, n)``, joint angles of the measured poses [rad].
        measured: ``(N, 3)``, positions of the reflector in the tracker's frame [m].
        q_test: ``(M, n)``, joint angles of the poses to be predicted [rad].
        millimetre: One millimetre [m], for packages that work in millimetres.
    """

    dh: np.ndarray
    limits: np.ndarray
    reflector: np.ndarray
    T_tracker_base: np.ndarray
    noise: float
    q: np.ndarray
    measured: np.ndarray
    q_test: np.ndarray
    millimetre: float


@dataclass(frozen=True, eq=False)
class Fitted:
    """What one fit gives.

    Attributes:
        predict: From joint angles ``(M, n)`` [rad] to positions of the reflector ``(M, 3)`` in the tracker's frame [m].
        parameters: Number of parameters that were fitted, the tracker's frame and the reflector included.
        evaluations: How many evaluations, steps or iterations the package reports; None if it reports none.
        counted: Which of these they are.
        standard_errors: Whether the package states standard errors, in a word or two.
    """

    predict: Callable[[np.ndarray], np.ndarray]
    parameters: int
    evaluations: int | None
    counted: str
    standard_errors: str


@dataclass(frozen=True)
class Answer:
    """What an adapter writes.

    Attributes:
        version: Version of the package.
        predicted: M positions of three coordinates [m], at ``Job.q_test`` in the tracker's frame.
        seconds: Processor time of each fit [s], the first one first.
        parameters, evaluations, counted, standard_errors: As in ``Fitted``.
    """

    version: str
    predicted: list[list[float]]
    seconds: list[float]
    parameters: int
    evaluations: int | None
    counted: str
    standard_errors: str


def write_job(path: Path, job: Job) -> None:
    """Write a job as JSON, all digits of its numbers kept."""
    content = {
        key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in vars(job).items()
    }
    path.write_text(json.dumps(content), encoding="utf-8")


def read_job(path: Path) -> Job:
    """Return the job that ``write_job`` wrote."""
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    values: dict[str, Any] = {
        key: np.array(value) if isinstance(value, list) else value for key, value in content.items()
    }
    return Job(**values)


def write_answer(path: Path, answer: Answer) -> None:
    """Write an answer as JSON."""
    path.write_text(json.dumps(asdict(answer)), encoding="utf-8")


def read_answer(path: Path, predictions: int) -> Answer:
    """Return an adapter's answer.

    Args:
        path: The file.
        predictions: How many positions it has to hold.

    Raises:
        ValueError: The file is no answer to a job of that size, or a number in it is not finite.
    """
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    try:
        answer = Answer(**content)
    except TypeError as error:
        raise ValueError(f"the answer has other fields: {error}") from None
    predicted = np.array(answer.predicted, dtype=float)
    if predicted.shape != (predictions, 3):
        raise ValueError(
            f"{predictions} positions were asked for, and the answer has the shape {predicted.shape}"
        )
    if not np.isfinite(predicted).all() or not np.isfinite(answer.seconds).all():
        raise ValueError("the answer holds a number that is not finite")
    return answer


def run(package: str, fit: Callable[[Job], Fitted], fits: int = FITS) -> None:
    """Answer a job with a package: ``ADAPTER.py JOB ANSWER``.

    Args:
        package: Name of its distribution.
        fit: Fits from the beginning, from data in memory.
        fits: How often it is done.
    """
    seconds = []
    for _ in range(fits):
        job = read_job(Path(sys.argv[1]))  # anew, so that nothing of an earlier fit is left in it
        start = time.process_time()
        fitted = fit(job)
        seconds.append(time.process_time() - start)
    answer = Answer(
        version=metadata.version(package),
        predicted=np.asarray(fitted.predict(job.q_test)).tolist(),
        seconds=seconds,
        parameters=fitted.parameters,
        evaluations=None if fitted.evaluations is None else int(fitted.evaluations),
        counted=fitted.counted,
        standard_errors=fitted.standard_errors,
    )
    write_answer(Path(sys.argv[2]), answer)


def link(alpha: float, a: float, theta: float, d: float) -> np.ndarray:
    """Return the transform ``(4, 4)`` Rx(alpha) Tx(a) Rz(theta) Tz(d) [rad, m]."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    return np.array(
        [
            [ct, -st, 0.0, a],
            [ca * st, ca * ct, -sa, -d * sa],
            [sa * st, sa * ct, ca, d * ca],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
