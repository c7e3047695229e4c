"""An injected warm-up that restarts: two warm bodies, by the matrix exponential."""

import numpy as np
import pytest
from scipy.linalg import expm

from scalar.simulation.injected.heat import warmed
from tests.simulation.injecting import injected


def test_two_bodies_exchange_heat():
    """The warmth of the links is that of the linear system with a constant power in each interval."""
    time = np.array([0.0, 30.0, 35.0, 400.0, 410.0, 600.0])
    works = np.array([True, True, False, True, True])
    M = np.array([[-20.0, 20.0, 5.0], [4.0, -5.0, 0.0], [0.0, 0.0, 0.0]]) / 120.0  # motors, links, power
    state, expected = np.zeros(3), [0.0]
    for span, at_work in zip(np.diff(time), works, strict=True):
        state[2] = at_work
        state = expm(M * span) @ state
        expected.append(state[1])
    np.testing.assert_allclose(warmed(time, works, 120.0)[1], expected, atol=2e-4)


def test_lengths_grow_at_work_and_shrink_in_stops():
    """Through each stretch of work the arm grows; a pause of many time constants takes all of it back, and so the truth begins cold."""
    entry = {"effect": "restarted_warm_up", "size": 1e-3, "constant_s": 40.0, "lengths": ["a_2"]}
    scene = injected(entry, stops={"count": 2, "duration_s": 1e4})
    time = scene.poses["time"].to_numpy()
    (after,) = np.nonzero(np.diff(time) > 60.0)
    assert len(after) == 2 and scene.truth["effects"][0]["stops"] == 2
    growth = scene.effects.parts[0].growth(scene.poses)
    np.testing.assert_allclose(growth[[0, *(after + 1)]], 0.0, atol=1e-8)
    inside = np.ones(len(growth) - 1, dtype=bool)
    inside[after] = False
    assert (np.diff(growth)[inside] > 0).all() and growth.max() < 1e-3


def test_stops_change_the_time_only():
    """Poses, points and all other columns are those of the scene without stops."""
    without, with_stops = injected(), injected(stops={"count": 3, "duration_s": 100.0})
    np.testing.assert_array_equal(without.points, with_stops.points)
    shift = with_stops.poses["time"] - without.poses["time"]
    assert shift.to_numpy() == pytest.approx(np.arange(len(shift)) * 4 // len(shift) * 100.0, abs=0.11)
    same = without.poses.columns.difference(["time", "temperature"])
    assert without.poses[same].equals(with_stops.poses[same])
