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

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.held_out.hold_out import HeldOutErrors, blocks
from scalar.diagnosis.held_out.repeated_runs import Answer, Run, available_cores, run_all
from scalar.diagnosis.held_out.shown_places import places_shown
from scalar.diagnosis.settings import Settings
from scalar.effects import Effect
from scalar.errors import ScalarError, Undetermined
from scalar.estimation.gross_errors import Cleaned
from scalar.estimation.model import Model
from scalar.estimation.pose_consistency import LEAST_TRUSTED
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array


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
        without_place: Number of poses that are not included because the others do not show where the target stands there.
    """

    folds: int
    answers: tuple[Answer, ...]
    failed: tuple[str, ...]
    errors: tuple[HeldOutErrors, HeldOutErrors]
    fold: Array
    over_all_poses: tuple[float, float]
    without_place: int = 0

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
        moving: ``(n,)`` bool, the joints by which poses differ (``repetitions.moving_joints``); None for all.
    """
    if folds < 2:
        return None
    numbered = _numbered(dataset)
    block, fold = _blocks(dataset, settings, folds, moving)
    parts = [np.flatnonzero(fold == k) for k in range(folds) if np.any(fold == k)]
    trained = [_trained_without(dataset, out) for out in parts]
    jobs = [(run, numbered.subset(rows), settings) for rows in trained]
    row = {int(pose): i for i, pose in enumerate(dataset.pose_ids)}
    kept = np.array([row[int(pose)] for pose in cleaned.dataset.pose_ids])
    order = numbered.poses["order"].to_numpy()[kept]
    judged = replace(cleaned.dataset, poses=cleaned.dataset.poses.assign(order=order))
    unseen = _Unseen(len(kept))
    answers = run_all(jobs, on_fold, cores or available_cores())
    for out, rows, answer in zip(parts, trained, answers, strict=True):
        unseen.add(judged, np.isin(kept, out), rows[kept], answer)
    known = np.isfinite(unseen.metric[0])
    own_block = np.unique(block[kept][known], return_inverse=True)[1]
    before, after = (
        HeldOutErrors(m[known], m[known], unseen.counts[known], own_block, settings.hold_out)
        for m in unseen.metric
    )
    return OuterSplit(
        len(parts),
        tuple(unseen.answers),
        tuple(unseen.failed),
        (before, after),
        fold[kept][known],
        unseen.over_all_poses(),
        unseen.without_place,
    )


class _Unseen:
    """What the runs of an outer split answer, and how well they predict the M poses that are no gross errors.

    Attributes:
        answers: The answers of the runs that succeeded.
        failed: Why the other runs failed, one line for each.
        metric: ``(2, M)`` [m^2], mean squared distances without effects and as shipped, each pose predicted by the run without it; NaN where
            that failed.
        counts: ``(M,)``, numbers of points.
        without_place: Number of poses at which the others do not show where the target stands; their distances stay NaN.
    """

    def __init__(self, n_poses: int) -> None:
        """Begin without any answer."""
        self.answers: list[Answer] = []
        self.failed: list[str] = []
        self.without_place = 0
        self.metric = np.full((2, n_poses), np.nan)
        self.counts = np.ones(n_poses)
        # The number of poses that each run left out, and its mean squared distances (2,) [m^2] over all poses.
        self._of_runs: list[tuple[float, Array]] = []

    def add(self, judged: Dataset, left_out: Array, trained: Array, answer: Answer | ScalarError) -> None:
        """Add the answer of a run, or the error that ended it.

        Args:
            judged: The M poses, with their order.
            left_out: ``(M,)`` bool, which of them the run left out.
            trained: ``(M,)`` bool, which of them it had.
            answer: Its answer.
        """
        try:
            if isinstance(answer, ScalarError):
                raise answer
            rows = _in_known_sessions(judged, trained)
            part, out = judged.subset(rows), left_out[rows]
            found = [_squared_distances(part, model) for model in (answer.before, answer.after)]
        except ScalarError as error:
            self.failed.append(str(error).splitlines()[0])
            return
        self.answers.append(answer)
        shown = ~out | _places_shown(part, answer.before, trained[rows])
        judgeable = out & shown
        seen = rows[judgeable]
        self.without_place += int(left_out.sum()) - len(seen)
        means = np.array([squares[shown].sum() / n[shown].sum() for squares, n in found])
        self._of_runs.append((float(len(seen)), means))
        for k, (squares, n) in enumerate(found):
            self.metric[k, seen], self.counts[seen] = (squares / n)[judgeable], n[judgeable]

    def over_all_poses(self) -> tuple[float, float]:
        """Return the mean squared distances [m^2] over all poses without effects and as shipped, as ``OuterSplit`` states them."""
        total = sum(n_out * squares for n_out, squares in self._of_runs)
        before, after = np.broadcast_to(total / max(sum(n_out for n_out, _ in self._of_runs), 1.0), 2)
        return float(before), float(after)


def _blocks(dataset: Dataset, settings: Settings, folds: int, moving: Array | None) -> tuple[Array, Array]:
    """Return the block and the part ``(N,)`` of each pose, with as many blocks in all as for ``settings.hold_out.folds`` parts."""
    q = dataset.q if moving is None else dataset.q[:, moving]
    n_blocks = settings.hold_out.folds * settings.hold_out.blocks_per_fold
    return blocks(q, replace(settings.hold_out, folds=folds, blocks_per_fold=max(n_blocks // folds, 1)))


def _numbered(dataset: Dataset) -> Dataset:
    """Return the dataset with its order of acquisition as a column, because the rows of a part no longer show it."""
    if "order" in dataset.poses:
        return dataset
    return replace(dataset, poses=dataset.poses.assign(order=np.arange(dataset.n_poses, dtype=float)))


def _trained_without(dataset: Dataset, out: Array) -> Array:
    """Return which poses ``(N,)`` bool a run has: those that are not left out, but for the rest of a tracker's session that places no tracker.

    Args:
        dataset: The N poses.
        out: Rows that are left out.
    """
    trained = np.ones(dataset.n_poses, dtype=bool)
    trained[out] = False
    session = dataset.session
    if session is not None and not dataset.planes:
        left = np.bincount(session[trained], minlength=int(session.max()) + 1)
        trained &= left[session] >= LEAST_TRUSTED
    return trained


def _in_known_sessions(dataset: Dataset, trained: Array) -> Array:
    """Return the rows ``(M,)`` of a tracker's poses whose session has trained poses; of planes, all rows.

    Args:
        dataset: The N poses.
        trained: ``(N,)`` bool.

    Raises:
        Undetermined: The sessions of the other poses come in another order, so that a model of those would take one for another.
    """
    session = dataset.session
    if session is None or dataset.planes:
        return np.arange(dataset.n_poses)
    known = np.flatnonzero(np.isin(session, session[trained]))
    if list(dict.fromkeys(session[known])) != list(dict.fromkeys(session[trained])):
        raise Undetermined(["sessions take turns, and without this part they begin in another order"])
    return known


def _places_shown(dataset: Dataset, model: Model, trained: Array) -> Array:
    """Return at which poses ``(N,)`` bool other poses show where the target stands, given the arm: an error there says something of the arm.

    A target in two sockets shows how the tracker is turned; without the few poses at one of them, the poses there would err by centimetres.

    Args:
        dataset: The N poses.
        model: A model of the trained poses.
        trained: ``(N,)`` bool, the poses that it was fitted to.
    """
    residuals = Residuals.of(dataset, model)
    N, m = dataset.n_poses, residuals.measurement.rows_per_pose
    J = residuals.linearise(model)[1][: N * m, model.blocks["target"]]
    return places_shown(J.reshape(N, m, -1), trained)


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
