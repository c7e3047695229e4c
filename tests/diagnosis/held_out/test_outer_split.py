"""The outer split: poses that took no part in a run, the same numbers on any number of processors, and what is not counted."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from scalar.data.dataset import Dataset
from scalar.diagnosis.held_out.hold_out import HeldOutErrors
from scalar.diagnosis.held_out.outer_split import OuterSplit, _places_shown, outer_split
from scalar.diagnosis.held_out.repeated_runs import Answer, _begin_work
from scalar.diagnosis.settings import DEFAULTS, Settings
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.gross_errors import Cleaned, clean
from scalar.estimation.residuals import Residuals
from tests.diagnosis.held_out.runs import geometry_alone, refuses_the_first
from tests.effects.injected import make_cell
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def cleaned() -> Cleaned:
    return clean(make_cell(seed=61, poses_per_plane=30, points_per_scan=12).dataset)


def split(cleaned: Cleaned, run=geometry_alone, folds: int = 4, dataset: Dataset | None = None) -> OuterSplit:
    """Return the outer split of a dataset."""
    found = outer_split(dataset or cleaned.dataset, cleaned, run, DEFAULTS, folds, lambda done, total: None)
    assert found is not None
    return found


def test_every_pose_is_predicted_by_a_run_without_it(cleaned, monkeypatch):
    """The errors are those of fits to the other parts, computed here one by one; every pose is left out once."""
    monkeypatch.setattr("scalar.diagnosis.held_out.outer_split.available_cores", lambda: 1)
    seen = []

    def run(dataset: Dataset, settings: Settings) -> Answer:
        seen.append(set(dataset.pose_ids))
        return geometry_alone(dataset, settings)

    found = split(cleaned, run)
    everything = set(cleaned.dataset.pose_ids)
    left_out = [everything - own for own in seen]
    assert len(seen) == 4 and set.union(*left_out) == everything
    assert sum(map(len, left_out)) == len(everything) == len(found.fold)
    for k, out in enumerate(left_out):
        rows = np.isin(cleaned.dataset.pose_ids, list(out))
        model = geometry_fit(cleaned.dataset.subset(~rows))[0]
        distances = Residuals.of(cleaned.dataset, model).pose_distances(model)
        np.testing.assert_allclose(
            np.sqrt(found.errors[0].metric[found.fold == k]), distances[rows], rtol=1e-9
        )


def test_the_numbers_do_not_depend_on_the_number_of_processes(cleaned, monkeypatch):
    """The numbers are the same to the last bit, however many processes run."""
    found = []
    for cores in (1, 2):
        monkeypatch.setattr(
            "scalar.diagnosis.held_out.outer_split.available_cores", lambda cores=cores: cores
        )
        found.append(split(cleaned))
    one, two = found
    for a, b in zip(one.errors, two.errors, strict=True):
        np.testing.assert_array_equal(a.metric, b.metric)
    for a, b in zip(one.answers, two.answers, strict=True):
        np.testing.assert_array_equal(a.after.vector, b.after.vector)


def blas_threads() -> set[int]:
    """Return how many threads the BLAS libraries of this process use."""
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_workers_keep_to_one_thread_of_blas():
    """However many threads the process itself uses, a worker uses one: threads of several workers would wait for one another."""
    with threadpool_limits(2):
        assert blas_threads() == {2}
        context = get_context("fork")
        with ProcessPoolExecutor(1, context, initializer=_begin_work, initargs=(os.getpid(),)) as pool:
            assert pool.submit(blas_threads).result() == {1}


def test_repetitions_are_left_out_together(cleaned):
    """A repetition of a pose is in the same part as the first such pose."""
    dataset = cleaned.dataset
    again = dataset.subset(np.r_[np.arange(dataset.n_poses), np.arange(0, dataset.n_poses, 7)])
    again = replace(again, poses=again.poses.assign(pose=np.arange(again.n_poses)))
    found = split(replace(cleaned, dataset=again))
    for row in range(1, again.n_poses):
        if np.array_equal(again.q[row], again.q[row - 1]):
            assert found.fold[row] == found.fold[row - 1]


def test_a_run_that_fails_is_said_and_not_counted(cleaned):
    """Poses whose run failed have no error; the reason is kept, and the other parts count."""
    found = split(cleaned, refuses_the_first)
    assert found.failed == ("the first pose is missing",) and len(found.answers) == 3
    assert 0 < len(found.fold) < cleaned.dataset.n_poses and np.isfinite(found.errors[1].rms)


def test_poses_at_which_the_others_do_not_show_the_place_of_the_tracker_are_not_counted():
    """A session has two poses away from the place of all its others: without them, nothing shows how the tracker is turned there."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=20, noise=1e-4, seed=12).dataset
    for second, shown in ((np.r_[np.full(8, 50), 51, 52], False), (np.arange(50, 60), True)):
        both = dataset.subset(np.r_[np.arange(50), second])
        rows = np.arange(both.n_poses)
        session = np.where(rows < 50, "a", "b")
        both = replace(both, poses=both.poses.assign(pose=rows, order=rows, session=session))
        places = _places_shown(both, geometry_fit(both)[0], trained=rows < both.n_poses - 2)
        assert places.tolist() == [*[True] * (len(rows) - 2), shown, shown]


@pytest.mark.parametrize("short", [1, 4])
def test_a_session_of_few_poses_costs_no_other_pose(short):
    """Where a part takes so much of a session that nothing shows where the tracker stood in it, the other poses of the part count all the same."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=20, noise=1e-4, seed=12).dataset
    few = np.arange(dataset.n_poses) >= dataset.n_poses - short
    dataset = replace(dataset, poses=dataset.poses.assign(session=np.where(few, "b", "a")))
    found = split(Cleaned(dataset, (), (), 0))
    assert not found.failed and len(found.answers) == 4
    assert found.without_place <= short and len(found.fold) == dataset.n_poses - found.without_place
    assert found.errors[0].rms < 1e-3


def test_poses_that_are_gross_errors_are_not_counted(cleaned):
    """Poses that the whole diagnosis sets aside have no error, but the runs have them among their poses."""
    kept = replace(cleaned, dataset=cleaned.dataset.subset(np.arange(5, cleaned.dataset.n_poses)))
    assert len(split(kept, dataset=cleaned.dataset).fold) == cleaned.dataset.n_poses - 5


def test_the_error_reported_is_that_of_the_whole_data():
    """With least squares of many unknowns, runs with four fifths of the data have visibly larger errors. On average over draws, the reported error is
    within 4 % of the error on fresh data, in squares, and that of the runs alone is at least 8 % larger.
    """
    rng = np.random.default_rng(3)
    n, p, folds = 80, 20, 5
    fold = np.arange(n) % folds
    reported, alone, true = [], [], []
    for _ in range(600):
        X, y = rng.standard_normal((n, p)), rng.standard_normal(n)
        whole = np.linalg.lstsq(X, y, rcond=None)[0]
        squares, left = np.empty(n), []
        for k in range(folds):
            out = fold == k
            part = np.linalg.lstsq(X[~out], y[~out], rcond=None)[0]
            squares[out] = (y[out] - X[out] @ part) ** 2
            left.append(np.mean((y - X @ part) ** 2))
        errors = HeldOutErrors(squares, squares, np.ones(n), fold)
        found = OuterSplit(folds, (), (), (errors, errors), fold, (float(np.mean(left)),) * 2)
        reported.append(found.unseen_rms(1, float(np.sqrt(np.mean((y - X @ whole) ** 2)))) ** 2)
        alone.append(errors.rms**2)
        true.append(1.0 + whole @ whole)  # the truth is zero, and fresh rows are standard normal
    assert np.mean(reported) == pytest.approx(np.mean(true), rel=0.04)
    assert np.mean(alone) > 1.08 * np.mean(true)


def test_what_runs_leave_on_all_poses_is_known(cleaned):
    """The error of the runs over all poses lies between that of fits on their own poses and that on the other poses."""
    found = split(cleaned)
    model = geometry_fit(cleaned.dataset)[0]
    seen = Residuals.of(cleaned.dataset, model).rms(model)
    assert seen**2 < found.over_all_poses[0] < found.errors[0].rms ** 2
    assert seen < found.unseen_rms(0, seen) < found.errors[0].rms


def test_fewer_than_two_parts_give_no_split(cleaned):
    """With fewer than two parts nothing is run, and there is no result."""
    assert outer_split(cleaned.dataset, cleaned, pytest.fail, DEFAULTS, 0, lambda done, total: None) is None


def test_a_run_confirms_an_effect_at_the_same_place(cleaned):
    """A run confirms an effect if it found it at the same place: the same joint, and for a gear at least one common order."""
    model = geometry_fit(cleaned.dataset)[0]
    chosen = [(JointScale(2),), (JointScale(3), JointHarmonic(4, (2, 5))), (JointHarmonic(4, (2,)),), ()]
    answers = tuple(Answer(model, model, effects, "scan_bias" if effects else None) for effects in chosen)
    found = replace(split(cleaned), answers=answers)
    assert found.selected_in(JointScale(2)) == 0.25
    assert found.selected_in(JointHarmonic(4, (2,))) == 0.5
    assert found.selected_in(JointHarmonic(4, (3,))) == 0.0
    assert found.noise_selected_in("scan_bias") == 0.75
