"""What a fit needs is counted, sizes are what they say, and the figure shows every way that was measured."""

import pandas as pd
import pytest

from benchmarks import limit
from benchmarks.contestants import Contest
from benchmarks.figure import LOOKS, draw
from benchmarks.limit import Machine, Need, need_of, needed
from benchmarks.other_solvers import CERES, JAX, OURS, YARDSTICK
from benchmarks.sizes import ENOUGH_SECONDS, MOST_ROUNDS, WHOLE, median_time, of_size
from tests.random_scene import make_scene

WAYS = {YARDSTICK, *CERES.values(), *JAX.values(), OURS, WHOLE}


def test_every_byte_is_counted_once():
    """Points have two coordinates and poses a joint angle for each joint, of eight bytes each, however often they are evaluated."""
    assert (
        needed(120, 6, 12_000, 23, 3, 5).bytes == needed(120, 6, 12_000, 23, 3, 9).bytes == 8 * (24_000 + 720)
    )


def test_operations_grow_with_what_is_computed():
    """An evaluation costs the same each time, more points cost their compression alone, and poses more than J'J of their rows."""
    base = needed(120, 6, 12_000, 23, 3, 5).operations
    one, two = (needed(120, 6, 12_000, 23, 3, k).operations for k in (6, 7))
    assert two - one == pytest.approx(one - base)
    assert one - base > 120 * 3 * 26 * 26
    assert needed(120, 6, 24_000, 23, 3, 5).operations - base == limit.POINT * 12_000
    assert needed(240, 6, 12_000, 23, 3, 5).operations < 2 * base


def test_what_a_contest_needs_is_read_from_it():
    """Poses, joints, points, free coordinates and planes are those of the contest."""
    contest = Contest(make_scene(poses_per_plane=10, points_per_scan=20).dataset)
    inner = len(contest.free) - 9
    assert need_of(contest, 4) == needed(30, 6, 600, inner, 3, 4)


def test_the_limit_is_the_longer_time():
    """Reading and computing may overlap, so that the slower of both decides."""
    machine = Machine(1e9, 1e10, "a test")
    assert machine.limit(Need(2e6, 1e6)) == pytest.approx(2e-3)
    assert machine.limit(Need(2e6, 5e7)) == pytest.approx(5e-3)


def test_without_a_compiler_numpy_measures_the_machine(monkeypatch):
    """Where no C compiler is found the rates are NumPy's, and it is said."""
    monkeypatch.setattr(limit.shutil, "which", lambda name: None)
    found = limit.machine()
    assert "no C compiler" in found.measured_by
    assert found.bytes_per_second > 0 and found.operations_per_second > 0


@pytest.mark.parametrize("poses", [15, 30, 75])
def test_a_size_has_all_planes(poses):
    """A part of a scene, or more than one of it, has so many poses and sees all of its planes."""
    scene = make_scene(poses_per_plane=10, points_per_scan=10).dataset
    dataset = of_size(scene, poses)
    assert dataset.n_poses == poses
    assert set(dataset.poses["plane"]) == set(scene.poses["plane"])


def test_a_slow_call_is_made_once_and_a_quick_one_often():
    """The first of quick calls warms up and is not counted; one that takes long is not made again."""
    calls = []

    def taking(seconds):
        calls.append(seconds)
        return seconds if len(calls) > 1 else 3 * seconds

    assert median_time(lambda: taking(ENOUGH_SECONDS)) == 3 * ENOUGH_SECONDS and len(calls) == 1
    calls.clear()
    assert median_time(lambda: taking(1e-3)) == 1e-3 and len(calls) == 1 + MOST_ROUNDS


def test_the_figure_shows_every_way(tmp_path):
    """Every way has a look of its own, and a table with all of them is drawn, whichever are missing at a size."""
    assert set(LOOKS) == WAYS and len(set(LOOKS.values())) == len(WAYS)
    rows = [
        {"way": way, "poses": poses, "points": points, "ms": 1.0 + poses, "mib": 200.0}
        for way in sorted(WAYS)
        for poses, points in ((60, 100), (120, 100), (120, 1000))
    ]
    table = pd.DataFrame([row for row in rows if (row["way"], row["points"]) != (WHOLE, 1000)])
    path = tmp_path / "measured.png"
    figure = draw(table.assign(machine="a processor"), path)
    assert path.read_bytes().startswith(b"\x89PNG")
    shown = [{line.get_label(): line.get_xdata().tolist() for line in panel.lines} for panel in figure.axes]
    assert all(panel[OURS] == [60, 120] for panel in (shown[0], shown[2]))
    assert all(panel[OURS] == [100, 1000] and panel[WHOLE] == [100] for panel in (shown[1], shown[3]))
    assert all(set(panel) == WAYS for panel in shown)
