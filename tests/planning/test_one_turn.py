"""Candidate poses stay within one turn of a joint, and within the limits of a slide, however far these go."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.declared import Sensor
from scalar.planning import after
from scalar.planning.after import After
from scalar.planning.candidates import draw_candidates
from scalar.planning.separation import Answer
from scalar.planning.workcell import Workcell
from scalar.robots import read_arm

SLIDE = {"a": 0.0, "alpha": 0.0, "d": 0.0, "theta": 0.0, "type": "prismatic", "limits": [0.0, 9.0]}


def test_a_joint_of_two_turns_takes_one_and_a_slide_its_whole_travel():
    """The joints of a UR turn twice: poses over both turns mean moves of a turn and twisted cables. A long rail is no such joint."""
    mapping = dict(read_arm("ur10e").mapping)
    robot = type(read_arm("ur10e").robot).from_mapping({**mapping, "joints": [SLIDE, *mapping["joints"]]})
    assert np.ptp(robot.limits[1]) > 2 * np.pi
    workcell = Workcell.of(robot, replace(Sensor("tracker", np.eye(4)), noise=1e-4), ())
    q = draw_candidates(workcell, 400, np.random.default_rng(0), one_turn=True).q
    spans = np.ptp(q, axis=0)
    assert spans[0] > 8.0 and q[:, 0].min() >= 0.0 and q[:, 0].max() <= 9.0
    assert np.all(spans[1:] <= 2 * np.pi) and np.all(
        spans[1:] > 0.9 * 2 * np.pi * np.minimum(1, np.ptp(robot.limits[1:], axis=1) / (2 * np.pi))
    )


@pytest.mark.parametrize(
    ("within", "over_several", "taken"),
    [(30.0, 90.0, True), (1.0, 2.0, True), (1.0, 90.0, False), (40.0, 1.0, True)],
)
def test_several_turns_are_taken_only_where_they_answer_more(within, over_several, taken, monkeypatch):
    """A question that one turn answers, or that nothing answers, needs no moves of more than a turn."""
    robot = read_arm("ur10e").robot
    workcell = Workcell.of(robot, replace(Sensor("tracker", np.eye(4)), noise=1e-4), ())

    def judged(_workcell, candidates, *_):
        signal = within if candidates == "one turn" else over_several
        return After([], [], [Answer(None, 0.0, signal, signal, signal)], [])

    monkeypatch.setattr(after, "poses_after", judged)
    found, _ = after.candidates_after(
        workcell, lambda one: "one turn" if one else "several", None, None, ([], [])
    )
    assert found == ("one turn" if taken else "several")
