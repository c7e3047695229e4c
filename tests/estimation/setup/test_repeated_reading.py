"""A tracker that does not see its target repeats the reading of the pose before; the refusal of such poses says so."""

from dataclasses import replace

import numpy as np
import pytest

from scalar import calibrate
from scalar.errors import InvalidInput
from scalar.estimation.setup.tables.repeated_reading import reading_repeated
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def tracked():
    """Return seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset


def with_readings(dataset, **of_rows):
    """Return the dataset with the points of some rows, named ``r<row>``, replaced by those of the rows that are given."""
    points = dataset.points.copy()
    for row, other in of_rows.items():
        points[int(row[1:])] = dataset.points[other]
    return replace(dataset, points=points)


def test_a_refused_pose_with_the_reading_of_the_one_before_is_said_to_have_it(tracked):
    """Two poses have the reading of a third, which stood before them; one has that of a pose far away, and of it nothing is said."""
    ids = tracked.pose_ids
    with pytest.raises(InvalidInput) as refused:
        calibrate(with_readings(tracked, r30=29, r31=29, r50=10))
    told = {int(str(f).split("pose ")[1].split()[0]): str(f) for f in refused.value.faults}
    assert set(told) == {int(ids[30]), int(ids[31]), int(ids[50])}
    for row in (30, 31):
        assert (
            f"its reading is exactly that of pose {ids[row - 1]}, although the flange moved by"
            in told[int(ids[row])]
        )
    assert "its reading is" not in told[int(ids[50])]


def test_a_repeated_reading_may_scatter(tracked):
    stale = with_readings(tracked, r30=29)
    stale.points[30] += 2e-4
    assert f"that of pose {tracked.pose_ids[29]} to 0.35 mm" in reading_repeated(stale, 30)


def test_the_order_is_that_of_acquisition_and_ends_with_a_session(tracked):
    """Rows that were sorted stand in another order, and the tracker may stand elsewhere in the next session."""
    stale = with_readings(tracked, r30=29)
    backwards = np.arange(75)[::-1]
    sorted_anew = replace(
        stale, poses=stale.poses.iloc[::-1].assign(order=backwards), points=stale.points[::-1]
    )
    assert reading_repeated(sorted_anew, 44) and not reading_repeated(sorted_anew, 45)
    sessions = replace(stale, poses=stale.poses.assign(session=np.arange(75) // 30))
    assert not reading_repeated(sessions, 30)


def test_an_arm_that_hardly_moves_has_the_same_reading(tracked):
    """Where the flange stays within two centimetres a similar reading is to be expected, and so it is at the first pose."""
    frame = tracked.poses.copy()
    joints = [name for name in frame if name.startswith("q")]
    frame.loc[frame.index[30], joints] = frame.loc[frame.index[29], joints].to_numpy() + 1e-3
    assert not reading_repeated(replace(with_readings(tracked, r30=29), poses=frame), 30)
    assert not reading_repeated(tracked, 0)
