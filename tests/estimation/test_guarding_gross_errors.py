"""Thresholds of gross errors: each is tested with data on both sides of it, so that half or double the threshold changes the decision."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.errors import Undetermined
from scalar.estimation import outlying_points, plane_labels
from scalar.estimation.gross_errors import Cleaned, clean, clean_given_effects
from scalar.estimation.line_breakdown import line_has_broken_down
from scalar.estimation.outlying_points import without_outlying_points
from scalar.estimation.plane_labels import other_labels
from scalar.estimation.pose_consistency import (
    _heavy_tailed,
    best_fitting,
    coarsely_consistent,
    in_runs,
    outlier_limit,
)
from scalar.estimation.settings import DEFAULTS, changed
from scalar.sensors.robust_scale import robust_std
from scalar.units import MM
from tests.random_scene import make_scene

GROSS = DEFAULTS.gross_errors


def scans(points_per_scan: int = 20, noise: float = 1e-5, off: dict[int, float] | None = None) -> Any:
    """Return a dataset of nine scans, some points of the first moved along z.

    Args:
        points_per_scan: Of each. noise: [m]. off: ``{point: by how much [m]}``.
    """
    dataset = make_scene(seed=1, poses_per_plane=3, points_per_scan=points_per_scan, noise=noise).dataset
    points = dataset.points.copy()
    for point, by in (off or {}).items():
        points[point, 1] += by
    return replace(dataset, points=points)


def test_a_point_nearer_than_the_least_error_stays_however_quiet_its_scan():
    """A point 0.3 mm off a scan with 10 micrometres of noise is set aside with a limit of 0.2 mm, and kept with 0.4 mm."""
    dataset = scans(off={5: 0.3 * MM})
    assert without_outlying_points(dataset, GROSS)[1] == 1
    assert (
        without_outlying_points(dataset, replace(GROSS, least_point_error=2 * GROSS.least_point_error))[1]
        == 0
    )


def test_a_short_scan_has_no_outlying_points():
    """Of seven points one is far off: it is set aside if five points are enough, and kept if ten are needed."""
    dataset = scans(points_per_scan=7, off={3: 5 * MM})
    assert without_outlying_points(dataset, GROSS)[1] == 1
    assert without_outlying_points(dataset, replace(GROSS, least_points=2 * GROSS.least_points))[1] == 0


def test_a_scan_with_many_points_off_its_line_is_corrupted():
    """If five of twenty points are off, they are dropped where a third may be, and the whole scan is dropped where a sixth may be."""
    dataset = scans(off=dict.fromkeys((2, 6, 11, 13, 17), 5 * MM))
    _, dropped, corrupted = without_outlying_points(dataset, GROSS)
    assert dropped == 5 and not corrupted.any()
    _, dropped, corrupted = without_outlying_points(
        dataset, replace(GROSS, corrupted_share=GROSS.corrupted_share / 2)
    )
    assert dropped == 0 and list(np.flatnonzero(corrupted)) == [0]


def test_a_line_is_found_among_strays_by_reweighting(monkeypatch):
    """With six of twenty points off to one side at one end, one round of reweighting gives a wrong line, and the usual number does not."""
    dataset = scans(off=dict.fromkeys(range(6), 10 * MM))
    assert without_outlying_points(dataset, GROSS)[1] == 6
    monkeypatch.setattr(outlying_points, "_ROUNDS", 1)
    assert without_outlying_points(dataset, GROSS)[1] != 6


def test_a_line_breaks_down_where_stray_points_scatter_far_beyond_the_core():
    """If a third of forty points scatter by four to five times the noise, a limit of three finds a breakdown, and one of six does not."""
    off = 1e-4 * np.random.default_rng(2).standard_normal(40)
    off[::3] += 0.7 * MM * (-1) ** np.arange(14)
    points = np.stack([np.linspace(-0.1, 0.1, 40), off], axis=1)
    assert line_has_broken_down(points, GROSS)
    assert not line_has_broken_down(points, replace(GROSS, line_breakdown=2 * GROSS.line_breakdown))


def test_a_pose_far_off_the_nominal_arm_is_left_out_at_first():
    """With a perfect arm, a scan 30 mm behind its plane is left out with a limit of 20 mm, and kept with 40 mm."""
    dataset = make_scene(
        seed=2,
        poses_per_plane=12,
        points_per_scan=10,
        length_error=0.0,
        angle_error=0.0,
        pose_offset=(0.0, 0.0),
    ).dataset
    points = dataset.points.copy()
    scan = slice(dataset.starts[4], dataset.starts[5])
    points[scan] *= 1 + 30 * MM / np.linalg.norm(points[scan], axis=1)[:, None] / 0.8
    dataset, everything = replace(dataset, points=points), np.ones(dataset.n_poses, dtype=bool)
    assert list(np.flatnonzero(~coarsely_consistent(dataset, everything, GROSS))) == [4]
    loose = replace(GROSS, coarse_pose_error=2 * GROSS.coarse_pose_error)
    assert coarsely_consistent(dataset, everything, loose).all()


@pytest.mark.parametrize(
    ("length", "n_off", "name", "value"),
    [(5, 5, "contiguous_run", 8), (5, 20, "run_by_chance", 0.05 / 20)],
)
def test_successive_poses_that_are_all_off_are_a_change(length, n_off, name, value):
    """Five successive poses of one plane are a change if four are enough and chance makes no such run; else they are outliers."""
    dataset = SimpleNamespace(plane_index=np.zeros(100, dtype=int))
    off = np.zeros(100, dtype=bool)
    off[40 : 40 + length] = True
    off[np.arange(n_off - length) * 2 + 50] = True
    assert list(np.flatnonzero(in_runs(dataset, off, GROSS))) == list(range(40, 40 + length))  # type: ignore[arg-type]
    assert not in_runs(dataset, off, replace(GROSS, **{name: value})).any()  # type: ignore[arg-type]


def test_a_few_distances_far_above_most_say_that_the_fit_was_dragged():
    """With one of a hundred poses 25 times as far off, the root mean square is two and a half times the median: above a limit of two, below four."""
    distances = np.r_[np.full(99, 1e-4), 25e-4]
    assert _heavy_tailed(distances, GROSS)
    assert not _heavy_tailed(distances, replace(GROSS, heavy_tail=2 * GROSS.heavy_tail))


@pytest.fixture(scope="module")
def labelled() -> Any:
    """Return a set with one wrong label, and which poses are right."""
    dataset = make_scene(seed=3, poses_per_plane=20, points_per_scan=10).dataset
    plane = dataset.poses["plane"].to_numpy(dtype=object).copy()
    plane[7] = next(name for name in dict.fromkeys(plane) if name != plane[7])
    keep = np.arange(dataset.n_poses) != 7
    return replace(dataset, poses=dataset.poses.assign(plane=plane)), keep


def test_a_pose_is_mislabelled_only_where_another_plane_is_far_nearer(labelled, monkeypatch):
    """A pose 0.9 mm from another plane is mislabelled if it is 6 mm from its own, and not if it is 3 mm from it."""
    dataset, keep = labelled
    assert list(other_labels(dataset, keep, [7], DEFAULTS)) == [7]
    names = list(dict.fromkeys(dataset.poses["plane"]))
    mine = names.index(dataset.poses["plane"][7])
    for own, labels in ((6 * MM, [7]), (3 * MM, [])):

        def distances(measurement: Any, T: Any, planes: Any, index: Any, own: float = own) -> Any:
            found = np.full(len(index), 0.05 * MM)
            found[7] = own if planes.names[index[7]] == names[mine] else 0.9 * MM
            return found

        monkeypatch.setattr(plane_labels, "pose_distances", distances)
        assert list(other_labels(dataset, keep, [7], DEFAULTS)) == labels


def test_the_better_part_of_a_planes_poses_is_more_than_half():
    """The better part is six of ten poses: more than half, as least trimmed squares needs, and few enough to be right if a third is wrong."""
    dataset: Any = SimpleNamespace(planes=("floor",), session=None, plane_index=np.zeros(10, dtype=int))
    assert best_fitting(dataset, np.arange(10.0), np.ones(10, dtype=bool), GROSS).sum() == 6


@pytest.mark.parametrize(
    ("poses", "near", "trusted"), [(2, 0, 2), (3, 0, 3), (3, 1, 3), (6, 0, 3), (7, 0, 0)]
)
def test_of_a_session_of_few_poses_some_are_trusted(poses, near, trusted):
    """Where a session has few poses, each is far off a fit without it; a longer one that is far off as a whole is not trusted."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=10, noise=1e-4, seed=7).dataset
    short = np.arange(dataset.n_poses) >= dataset.n_poses - poses
    dataset = replace(dataset, poses=dataset.poses.assign(session=np.where(short, "b", "a")))
    distance = np.where(short & (np.arange(dataset.n_poses) < dataset.n_poses - near), 1.0, 1e-4)
    core = best_fitting(dataset, distance, np.ones(dataset.n_poses, dtype=bool), GROSS)
    assert core[short].sum() == trusted


def test_how_far_off_a_pose_may_be():
    """The limit is about a millimetre, the error of an arm that is not calibrated, or else ten times the scatter of the poses."""
    normal = np.abs(np.random.default_rng(0).standard_normal(1000))
    assert 0.7 * MM < outlier_limit(1e-6 * normal, GROSS) < 1.5 * MM
    scatter = robust_std(1e-3 * normal)
    assert 7 * scatter < outlier_limit(1e-3 * normal, GROSS) < 15 * scatter


@pytest.mark.parametrize(
    ("off", "between", "changed", "aside"),
    [
        (1, 0, {}, 1),
        (2, 0, {}, 2),
        (2, 0, {"most_apart": GROSS.most_apart / 2}, 0),
        (4, 0, {}, 0),
        (2, 1, {}, 0),
        (2, 1, {"most_late": 2 * GROSS.most_late}, 2),
    ],
)
def test_what_stands_out_late_is_few(off, between, changed, aside):
    """Of sixty poses one may be set aside in any case; one in twenty where all others are far from those that stand out, else fewer."""
    dataset = make_scene(seed=3, poses_per_plane=20, points_per_scan=4).dataset
    dataset = dataset.subset(np.arange(60))
    cleaned = Cleaned(dataset, (), (), 0)
    distance = np.full(60, 0.1 * MM)
    distance[[7, 22, 38, 53][:off]] = 5 * MM
    distance[[14][:between]] = 0.7 * MM
    found = clean_given_effects(cleaned, distance, settings=replace(GROSS, **changed))
    assert len(found.outlier_poses) == aside


def test_a_session_that_loses_its_last_pose_late_is_refused():
    """Nothing would say where the tracker stood in it; the model would have a frame less than the dataset has sessions."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=20, noise=1e-4, seed=7).dataset
    last = np.arange(dataset.n_poses) == dataset.n_poses - 1
    dataset = replace(dataset, poses=dataset.poses.assign(session=np.where(last, "b", "a")))
    with pytest.raises(Undetermined, match="no pose of session b agrees"):
        clean_given_effects(Cleaned(dataset, (), (), 0), np.where(last, 5 * MM, 0.1 * MM))


def test_a_third_of_the_poses_must_not_be_set_aside_where_a_fifth_may(labelled):
    """With wrong labels of a quarter of the poses, the data are accepted if nearly half may be set aside, and refused if less than a quarter may."""
    dataset, _ = labelled
    plane = dataset.poses["plane"].to_numpy(dtype=object).copy()
    names = list(dict.fromkeys(plane))
    for i in range(0, 60, 4):
        plane[i] = names[(names.index(plane[i]) + 1) % 3]
    wrong = replace(dataset, poses=dataset.poses.assign(plane=plane))
    assert len(clean(wrong).mislabelled_poses) >= 15
    with pytest.raises(Undetermined):
        clean(wrong, changed(DEFAULTS, {"gross_errors.most_set_aside": GROSS.most_set_aside / 2}))
