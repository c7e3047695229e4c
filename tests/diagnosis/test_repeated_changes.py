"""Names that are given more often than one cause of their kind can explain."""

import pytest

from scalar.diagnosis.repeated_changes import repetitions


def at(order: float) -> dict:
    """Return the target of a change at a moment."""
    return {"at": {"order": order, "time": None}}


@pytest.mark.parametrize(
    ("answers", "times"),
    [
        ([("sensor_slip", at(40))], [1]),
        ([("sensor_slip", at(40)), ("sensor_slip", at(80))], [2, 2]),
        ([("plane_moved", {"plane": "a", **at(4)}), ("plane_moved", {"plane": "b", **at(4)})], [1, 1]),
        ([("plane_moved", {"plane": p, **at(4)}) for p in "abc"], [3, 3, 3]),
        ([("target_drift", {}), ("target_drift", at(46))], [2, 2]),
        ([("thermal_drift", {}), ("thermal_drift", {})], [2, 2]),
        ([("joint_scale", {"joint": 2}), ("joint_scale", {"joint": 3})], [1, 1]),
        ([("sensor_slip", at(40)), ("plane_moved", {"plane": "a", **at(40)})], [1, 1]),
    ],
)
def test_one_cause_is_expected_at_one_place(answers, times):
    """A sensor slips once, each of two planes may be knocked, three are none by accident; a tracker that drifts and is knocked is one doubtful cause."""
    assert repetitions(answers) == times
