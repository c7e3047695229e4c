"""Where stray points are so many that the lines of the scans are lost, it is said; where they are not, nothing is refused."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis import cleaning, diagnose
from scalar.errors import Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.gross_errors import TooManyStrayPoints, clean, without_stray_points
from scalar.estimation.line_breakdown import line_has_broken_down, share_of_broken_lines
from scalar.estimation.settings import DEFAULTS
from scalar.units import MM
from tests.diagnosis.gross_errors import spoiled
from tests.effects.injected import make_cell
from tests.random_scene import make_scene

GROSS = DEFAULTS.gross_errors
LAWS = {
    "normal": lambda rng, M: rng.standard_normal(M),
    "Laplace": lambda rng, M: rng.laplace(size=M),
    "Student, three degrees of freedom": lambda rng, M: rng.standard_t(3, M),
    "a bow of ten standard deviations": lambda rng, M: (
        10 * np.linspace(-1, 1, M) ** 2 + rng.standard_normal(M)
    ),
    "waves": lambda rng, M: 4 * np.sin(np.linspace(0, 12, M) + rng.uniform(0, 6)) + rng.standard_normal(M),
}


def scan(off: np.ndarray) -> np.ndarray:
    """Return the points ``(M, 2)`` [m] of a scan of 0.2 m that are ``off`` [m] their line."""
    return np.stack([np.linspace(-0.1, 0.1, len(off)), 0.3 + off], axis=1)


def with_stray_points(dataset, share, least, most, side, where, seed=1):
    """Return a dataset with points that are off along their rays by ``least`` to ``most`` [m], anywhere or at one end of each scan."""
    rng = np.random.default_rng(seed)
    stray = np.zeros(len(dataset.points), dtype=bool)
    for begin, end in zip(dataset.starts[:-1], dataset.starts[1:], strict=True):
        count = rng.binomial(end - begin, share)
        chosen = begin + (rng.permutation(end - begin)[:count] if where == "anywhere" else np.arange(count))
        stray[chosen] = True
    away = rng.uniform(least, most, stray.sum())
    if side == "both":
        away *= rng.choice([-1.0, 1.0], len(away))
    points = dataset.points.copy()
    points[stray] *= (1 + away / np.linalg.norm(points[stray], axis=1))[:, None]
    return replace(dataset, points=points)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("count", [12, 16, 20, 26, 32, 60, 200])
def test_noise_of_one_law_does_not_break_a_line(law, count):
    """Of 60 scans with 0.2 mm of noise, short or long, at most half as many count as broken as it takes to refuse a dataset."""
    rng = np.random.default_rng([count, len(law)])
    broken = [line_has_broken_down(scan(2e-4 * LAWS[law](rng, count))) for _ in range(60)]
    assert np.mean(broken) <= GROSS.most_set_aside / 2


@pytest.mark.parametrize("size", [(0.5 * MM, 3 * MM), (2 * MM, 30 * MM)])
@pytest.mark.parametrize(
    ("share", "side", "where"),
    [(0.4, "both", "anywhere"), (0.5, "both", "anywhere"), (0.6, "both", "anywhere"), (0.4, "one", "anywhere"),
     (0.6, "one", "anywhere"), (0.4, "one", "end"), (0.5, "one", "end")],
)  # fmt: skip
def test_a_breakdown_is_refused(size, share, side, where):
    """If stray points of any kind are more than lines withstand, the exit status is 3 and the text speaks of points."""
    dataset = with_stray_points(
        make_cell(seed=3, poses_per_plane=25, points_per_scan=40).dataset,
        share,
        size[0],
        size[1],
        side,
        where,
    )
    with pytest.raises(TooManyStrayPoints, match="points lie off any common line") as caught:
        clean(dataset)
    assert caught.value.exit_status == 3


def test_calibrate_and_diagnose_refuse_alike():
    """With 40 % of stray points neither command gives an answer, and neither searches the set-up for a cause."""
    cell = make_cell(seed=4, poses_per_plane=25, points_per_scan=40)
    dataset = with_stray_points(cell.dataset, 0.4, 0.5 * MM, 3 * MM, "both", "anywhere")
    for answer in (calibrate, diagnose):
        with pytest.raises(TooManyStrayPoints):
            answer(dataset)


def test_a_calibration_says_that_points_are_stray():
    """With one stray point in a hundred the calibration says how many there are, and without them it says nothing of points."""
    dataset = make_cell(seed=5, poses_per_plane=30).dataset
    assert not calibrate(dataset).summary["setup"]
    bad, injected = spoiled(dataset, np.random.default_rng(2), points=0.01)
    (said,) = calibrate(bad).summary["setup"]
    assert said["what"] == "points" and said["sentence"].startswith(
        f"{len(injected['points'])} points lie off the line"
    )


@pytest.mark.parametrize(("noise", "ratio"), [(1e-4, 0), (4e-5, 0), (1e-5, 1)])
def test_scatter_far_above_the_stated_noise_is_said(noise, ratio):
    """With 0.1 mm of noise, a stated noise of 0.01 mm is remarked on, and one of 0.04 mm is not."""
    dataset = make_cell(seed=5, poses_per_plane=30).dataset
    stated = replace(dataset, sensor=replace(dataset.sensor, noise=noise))
    assert [s["what"] for s in calibrate(stated).summary["setup"]] == ["noise"] * ratio


def test_nine_stray_points_in_ten_are_said():
    """With nine stray points in ten no line is found and nothing is refused, but the message says that many of the points are stray."""
    data = make_cell(seed=5, poses_per_plane=30, points_per_scan=40).dataset
    dataset = with_stray_points(data, 0.9, 0.5 * MM, 3 * MM, "one", "anywhere")
    (said,) = calibrate(dataset).summary["setup"]
    assert said["what"] == "noise" and "many of the points are stray" in said["sentence"]


def test_strays_that_are_found_break_nothing():
    """With a tenth of stray points, scans of two and of eleven points, or no scanner at all, nothing is refused."""
    data = make_cell(seed=6, poses_per_plane=20).dataset
    for dataset in (
        with_stray_points(data, 0.1, 2 * MM, 30 * MM, "one", "anywhere"),
        make_cell(seed=6, poses_per_plane=20, points_per_scan=2).dataset,
        make_cell(seed=6, poses_per_plane=20, points_per_scan=11, noise=1e-3).dataset,
        make_scene(kind="probe", seed=1, poses_per_plane=20).dataset,
    ):
        kept, _, corrupted = without_stray_points(dataset)
        assert share_of_broken_lines(kept, corrupted) < GROSS.most_set_aside / 4


@pytest.mark.parametrize(("farthest", "refused"), [(9 * MM, False), (11 * MM, True)])
def test_a_pose_that_stays_far_off_is_refused_whatever_most_have(monkeypatch, farthest, refused):
    """A pose that is a centimetre off with everything in the model is refused, although the limit grows with gross errors that drag the fit."""
    dataset = make_scene(kind="probe", seed=1, poses_per_plane=20).dataset
    distances = np.r_[np.full(dataset.n_poses - 1, 0.1 * MM), farthest]
    state: Any = SimpleNamespace(
        dataset=dataset,
        model=None,
        settings=SimpleNamespace(estimation=DEFAULTS),
        residuals=SimpleNamespace(pose_distances=lambda model: distances),
    )
    monkeypatch.setattr(cleaning, "refuse_wrong_setup", lambda dataset: None)
    with pytest.raises(Undetermined, match=r"pose 60 lies 11\.0 mm from") if refused else nullcontext():
        cleaning.refuse_gross_errors_left(dataset, state)
