"""Errors on unseen poses, by an outer split around the whole diagnosis: cleaning, selection, spectrum, variance components and fit.

If a selected model is tested on poses that took part in the selection, its estimated error is too small (Cawley and Talbot, Journal of Machine
Learning Research 11, 2010; Varma and Simon, BMC Bioinformatics 7, 2006). The whole diagnosis is therefore run anew without each part of the poses,
and the calibrations of that run predict the part.
Parts are made of blocks of successive poses, and repetitions of a pose belong to one part, as in ``hold_out``. Poses that the diagnosis of all poses
sets aside as gross errors are not counted. A run has fewer poses than the whole diagnosis, so its errors are larger; the reported error is corrected
for that (Burman, Biometrika 76, 1989). The share of runs that select an effect measures its stability (stability selection: Meinshausen and
Bühlmann, Journal of the Royal Statistical Society B 72, 2010).
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import active_children, get_all_start_methods, get_context
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from scalar.data.dataset import Dataset
from scalar.data.io.processes import end_with
from scalar.diagnosis.hold_out import HeldOutErrors, blocks
from scalar.diagnosis.settings import Settings
from scalar.effects import Effect
from scalar.errors import ScalarError, Undetermined
from scalar.estimation.gross_errors import Cleaned
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array


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


Run = Callable[[Dataset, Settings], Answer]


@dataclass(frozen=True, eq=False)
class OuterSplit:
    """The answers of the runs without a part of the poses, and the errors on that part.

    Attributes:
        folds: Number of parts.
        answers: The answers of the runs that succeeded.
        failed: Why the other runs failed, one line for each.
        errors: Errors without effects and as shipped, each pose predicted by the run without it; poses whose run failed are not included.
        fold: ``(N,)``, the part of each of these poses.
        over_all_poses: Mean squared distances [m^2] without effects and as shipped, over all poses that are no gross errors, whether or not a run
            left them out; averaged over the runs with the number of poses that each left out as weight.
    """

    folds: int
    answers: tuple[Answer, ...]
    failed: tuple[str, ...]
    errors: tuple[HeldOutErrors, HeldOutErrors]
    fold: Array
    over_all_poses: tuple[float, float]

    def unseen_rms(self, which: int, seen_rms: float) -> float:
        """Return the root mean square error [m] of the whole diagnosis on unseen poses.

        Its square is ``L(left out) + L(whole) - mean L(run)``, correct to second order in one over the number of poses (Burman, 1989, eq. 2.3). L is
        a mean squared distance: of the poses left out from their runs, of all poses from the whole diagnosis, and of all poses from a run. The result
        is never below the smaller one of ``seen_rms`` and the error on the parts that were left out.

        Args:
            which: 0 without effects, 1 as shipped.
            seen_rms: Root mean square error of the whole diagnosis on the poses to which it was fitted [m].
        """
        corrected = self.errors[which].rms ** 2 + seen_rms**2 - self.over_all_poses[which]
        return float(np.sqrt(max(corrected, min(seen_rms, self.errors[which].rms) ** 2)))

    def selected_in(self, effect: Effect) -> float:
        """Return the share of runs that found an effect at the same place; for a flexible term, one along a common variable."""
        return self._share(lambda answer: any(_same(effect, other) for other in answer.effects))

    def noise_selected_in(self, name: str) -> float:
        """Return the share of runs whose likeliest variance component has this name."""
        return self._share(lambda answer: answer.noise == name)

    def std_over_parts(self, errors: HeldOutErrors) -> tuple[float, float]:
        """Return the standard deviations over the parts of the root mean square error and of the largest error [m]; NaN with one part."""
        parts = [self.fold == k for k in np.unique(self.fold)]
        if len(parts) < 2:
            return float("nan"), float("nan")
        of_parts = [replace(errors, metric=errors.metric[part], counts=errors.counts[part]) for part in parts]
        return (
            float(np.std([e.rms for e in of_parts], ddof=1)),
            float(np.std([e.largest for e in of_parts], ddof=1)),
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return the entry of ``diagnosis.json``."""
        return {"folds": self.folds, "failed": list(self.failed), "poses": len(self.fold)}

    def _share(self, chosen: Callable[[Answer], bool]) -> float:
        """Return the share of answers for which a condition holds."""
        return sum(map(chosen, self.answers)) / len(self.answers)


def _same(effect: Effect, other: Effect) -> bool:
    """Return whether another run's effect confirms an effect: the same place or the same answer; for flexible terms, a common variable."""
    if effect.flexible:
        return other.flexible and bool(set(effect.depends_on) & set(other.depends_on))
    return not other.flexible and (effect.same_place(other) or effect.same_answer(other))


def outer_split(
    dataset: Dataset,
    cleaned: Cleaned,
    run: Run,
    settings: Settings,
    folds: int,
    on_fold: Callable[[int, int], None],
    cores: int | None = None,
    moving: Array | None = None,
) -> OuterSplit | None:
    """Return the answers and errors of the runs without a part of the poses, or None if there are fewer than two parts.

    Args:
        dataset: All that was measured, gross errors included.
        cleaned: The dataset without the gross errors that the diagnosis of all poses sets aside.
        run: Diagnoses a dataset; a function that other processes can import by its name.
        settings: Thresholds.
        folds: Number of parts.
        on_fold: Called before the first and after each run, with the number of runs that are done and the number of all runs.
        cores: Number of runs at once; None for as many as there are processors that this process may use.
        moving: ``(n,)`` bool, the joints by which poses differ (``hold_out.moving_joints``); None for all.
    """
    if folds < 2:
        return None
    numbered = _numbered(dataset)
    q = dataset.q if moving is None else dataset.q[:, moving]
    n_blocks = settings.hold_out.folds * settings.hold_out.blocks_per_fold
    block, fold = blocks(
        q, replace(settings.hold_out, folds=folds, blocks_per_fold=max(n_blocks // folds, 1))
    )
    parts = [np.flatnonzero(fold == k) for k in range(folds) if np.any(fold == k)]
    jobs = [(run, numbered.subset(np.delete(np.arange(dataset.n_poses), out)), settings) for out in parts]
    row = {int(pose): i for i, pose in enumerate(dataset.pose_ids)}
    kept = np.array([row[int(pose)] for pose in cleaned.dataset.pose_ids])
    judged = replace(
        cleaned.dataset, poses=cleaned.dataset.poses.assign(order=numbered.poses["order"].to_numpy()[kept])
    )
    answers: list[Answer] = []
    failed: list[str] = []
    metric = np.full((2, len(kept)), np.nan)
    counts = np.ones(len(kept))
    over_all_poses: list[
        tuple[float, Array]
    ] = []  # (number of poses that the run left out, mean squared distances)
    for out, answer in zip(parts, _run_all(jobs, on_fold, cores or available_cores()), strict=True):
        left_out = np.isin(kept, out)
        try:
            if isinstance(answer, ScalarError):
                raise answer
            found = [_squared_distances(judged, model) for model in (answer.before, answer.after)]
        except ScalarError as error:
            failed.append(str(error).splitlines()[0])
            continue
        answers.append(answer)
        over_all_poses.append(
            (float(left_out.sum()), np.array([squares.sum() / n.sum() for squares, n in found]))
        )
        for k, (squares, n) in enumerate(found):
            metric[k, left_out], counts[left_out] = (squares / n)[left_out], n[left_out]
    known = np.isfinite(metric[0])
    own_block = np.unique(block[kept][known], return_inverse=True)[1]
    errors = [HeldOutErrors(m[known], m[known], counts[known], own_block, settings.hold_out) for m in metric]
    mean = sum(n_out * squares for n_out, squares in over_all_poses) / max(
        sum(n_out for n_out, _ in over_all_poses), 1.0
    )
    before, after = np.broadcast_to(mean, 2)
    return OuterSplit(
        len(parts),
        tuple(answers),
        tuple(failed),
        (errors[0], errors[1]),
        fold[kept][known],
        (float(before), float(after)),
    )


def _numbered(dataset: Dataset) -> Dataset:
    """Return the dataset with its order of acquisition as a column, because the rows of a part no longer show it."""
    if "order" in dataset.poses:
        return dataset
    return replace(dataset, poses=dataset.poses.assign(order=np.arange(dataset.n_poses, dtype=float)))


def _squared_distances(dataset: Dataset, model: Model) -> tuple[Array, Array]:
    """Return for each pose ``(N,)`` the sum of the squared distances [m^2] of its points from a model, and the number of points.

    Raises:
        Undetermined: The model was fitted without one of the targets or sessions of the dataset.
    """
    residuals = Residuals.of(dataset, model)
    if residuals.measurement.initial_target(dataset).parameter_names != model.target.parameter_names:
        raise Undetermined(
            ["all poses of one target or session lie in one part: no other part tells where it stands"]
        )
    return residuals.squared_distances(model)


def _run_all(
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
    """Return the answer of a run, or the error that ended it."""
    try:
        return run(dataset, settings)
    except ScalarError as error:
        return error


def available_cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
