"""The line of ``scalar plan`` on moves that touch something names one move or several."""

import pytest

from scalar.cli.plan_files import _lines_on_touching


@pytest.mark.parametrize(
    ("ids", "begins"),
    [
        ([49], "the move from pose 49 to the next"),
        ([13, 33, 48], "the moves from poses 13, 33, 48, each to the next"),
    ],
)
def test_moves_that_touch_are_named_by_the_pose_before(ids, begins):
    """One move is said in the singular, several in the plural."""
    (line,) = _lines_on_touching(ids)
    assert line.strip().startswith(begins) and "add a pose in between" in line
    assert _lines_on_touching([]) == []
