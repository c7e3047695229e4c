"""Degrees are written beside millimetres, and radians beside metres, unless the user stated another pair."""

import pytest

from scalar.data.table_units import units_to_write

JOINTS = ["q1", "q2"]
IN_DEGREES = ["q1_deg", "q2_deg"]
FRAME = ["x", "y", "z", "rx_deg", "ry_deg", "rz_deg"]


@pytest.mark.parametrize(
    ("text", "columns", "pair"),
    [
        (None, JOINTS, ("m", "rad")),
        ("deg,mm", JOINTS, ("mm", "deg")),
        ("deg", JOINTS, ("mm", "deg")),
        ("deg,m", JOINTS, ("m", "deg")),
        ("m,deg", JOINTS, ("m", "deg")),
        ("rad", IN_DEGREES, ("m", "rad")),
        (None, ["pose", *IN_DEGREES, "note"], ("mm", "deg")),
        (None, ["q1_m", "q2_deg"], ("m", "deg")),
        (None, ["q1", "q2_deg"], ("m", "deg")),
        (None, ["pose", *FRAME], ("m", "deg")),
    ],
)
def test_lengths_follow_the_angles_where_nothing_else_is_stated(text, columns, pair):
    """A table or option that states metres for any length keeps them; one that states degrees alone is written with millimetres."""
    written = units_to_write(text, columns)
    assert (written.length, written.angle) == pair
    assert written.in_words == f", lengths in {pair[0]}, angles in {pair[1]}"
