"""Repeat the diagnosis on parts of the poses, several at once in processes of their own."""

from __future__ import annotations

import gc
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import active_children, get_all_start_methods, get_context

from threadpoolctl import threadpool_limits

from scalar.data.dataset import Dataset
from scalar.data.io.processes import end_with
from scalar.diagnosis.fit.freed_memory import give_back
from scalar.diagnosis.settings import Settings
from scalar.effects import Effect
from scalar.errors import ScalarError
from scalar.estimation.model import Model


@dataclass(frozen=True, eq=False)
class Answer:
    """The result of a diagnosis of some of the poses.

    Attributes:
        before, after: The models of the calibrations that it would ship, without effects and as shipped.
        effects: The effects that it found.
        noise: Name of its likeliest variance component, or None.
    """

    before: Model
    after: Model
    effects: tuple[Effect, ...]
    noise: str | None


_MANY_POSES = 2_000  # of which a run leaves tens of megabytes, and of 12,000 hundreds; with fewer, freeing them takes longer than it is worth
Run = Callable[[Dataset, Settings], Answer]


def run_all(
    jobs: Sequence[tuple[Run, Dataset, Settings]], on_fold: Callable[[int, int], None], cores: int
) -> Iterator[Answer | ScalarError]:
    """Yield the answers in the order of the jobs; as many jobs run at once as there are cores."""
    cores = min(len(jobs), cores)
    on_fold(0, len(jobs))
    if cores < 2 or "fork" not in get_all_start_methods():
        for k, job in enumerate(jobs):
            yield _answered(*job)
            on_fold(k + 1, len(jobs))
        return
    # The processes are forked, so that they know effects from outside the package as well.
    others = set(active_children())
    with ProcessPoolExecutor(
        cores, mp_context=get_context("fork"), initializer=_begin_work, initargs=(os.getpid(),)
    ) as pool:
        try:
            futures = [pool.submit(_answered, *job) for job in jobs]
            for done, _ in enumerate(as_completed(futures), start=1):
                on_fold(done, len(jobs))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for worker in set(active_children()) - others:
                worker.terminate()
            raise
    yield from (future.result() for future in futures)


def _begin_work(parent: int) -> None:
    """Make a worker end with the process that started it, or when that process terminates it; only that process handles interruptions.

    Each worker keeps to one thread of BLAS: threads of several workers wait for one another, and take ten times as long.
    """
    threadpool_limits(1)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with(parent)


def _answered(run: Run, dataset: Dataset, settings: Settings) -> Answer | ScalarError:
    """Return the answer of a run, or the error that ended it.

    States of a run and the rows that they share refer to one another, so that only the collector frees them, hundreds of megabytes at 12,000 poses.
    """
    try:
        return run(dataset, settings)
    except ScalarError as error:
        return error
    finally:
        if dataset.n_poses > _MANY_POSES:
            gc.collect()
            give_back()


def available_cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
