"""The moves to poses follow their order, stay within sessions, and are kept by subsets of a dataset."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.data.moves import (
    TRAVELS,
    last_move_columns,
    moves,
    passing_column,
    side_column,
    step_column,
    wind_up_column,
)
from scalar.data.poses import Poses
from tests.random_scene import make_scene
from tests.turning import turning


def frame(angles, **columns):
    """Return a table of one joint's angles."""
    return pd.DataFrame({"q1": angles, **columns})


def steps_and_sides(table, n_joints=1):
    """Return the steps [rad] of joint 1 and the signs of its last moves."""
    found = moves(table, turning(n_joints))
    return found[step_column(1)].tolist(), found[side_column(1)].tolist()


def test_steps_and_sides_follow_the_order():
    """A step is the difference to the pose before in the order; a joint at rest keeps its side; no move leads to the first pose."""
    step, side = steps_and_sides(frame([0.0, 1.0, 1.0, 0.5, 0.5]))
    assert step == [0.0, 1.0, 0.0, -0.5, 0.0]
    assert side == [0.0, 1.0, 1.0, -1.0, -1.0]
    step, side = steps_and_sides(frame([0.5, 0.0, 1.0], order=[2.0, 0.0, 1.0]))
    assert (step, side) == ([-0.5, 0.0, 1.0], [-1.0, 0.0, 1.0])


def test_a_joint_that_slides_moves_from_smaller_steps_on():
    """A millimetre is a move of a joint that slides, and a milliradian is none of one that turns; a tenth of a millimetre is neither."""
    table = frame([0.0, 0.5, 0.499, 0.4991])
    assert moves(table, turning(1))[side_column(1)].tolist() == [0.0, 1.0, 1.0, 1.0]
    assert moves(table, [True])[side_column(1)].tolist() == [0.0, 1.0, -1.0, -1.0]
    seen = Poses.from_frame(table, [True], order_is_row=True)
    assert seen.columns[side_column(1)].tolist() == [0.0, 1.0, -1.0, -1.0]
    given = Poses.from_arrays(table[["q1"]], {"order": np.arange(4.0)}, [True])
    assert given.columns[side_column(1)].tolist() == [0.0, 1.0, -1.0, -1.0]


def test_no_move_is_known_after_a_gap_or_in_a_new_session():
    """If the order counts poses, no move is known after a missing number, nor at a new session; an order of times has no gaps."""
    assert steps_and_sides(frame([0.0, 1.0, 2.0, 2.0, 3.0], order=[0.0, 1.0, 3.0, 4.0, 5.0])) == (
        [0.0, 1.0, 0.0, 0.0, 1.0],
        [0.0, 1.0, 0.0, 0.0, 1.0],
    )
    assert steps_and_sides(frame([0.0, 1.0, 2.0], session=["a", "a", "b"]))[0] == [0.0, 1.0, 0.0]
    assert steps_and_sides(frame([0.0, 1.0, 2.0], order=[0.0, 7.5, 21.0]))[0] == [0.0, 1.0, 1.0]


@pytest.mark.parametrize("travel", TRAVELS)
def test_the_wind_up_follows_its_recursion(travel):
    """Pose after pose it approaches the sign of the step; it is 0 at the first pose and after a gap."""
    rng = np.random.default_rng(4)
    angles = np.cumsum(rng.choice([-1.0, 1.0], 60) * np.exp(rng.uniform(np.log(0.005), 0.0, 60)))
    order = np.arange(60.0) + 5.0 * (np.arange(60) >= 40)
    wind_up, expected = 0.0, []
    for k in range(60):
        if k in (0, 40):
            wind_up = 0.0
        else:
            step = angles[k] - angles[k - 1]
            wind_up = np.sign(step) + (wind_up - np.sign(step)) * np.exp(-abs(step) / travel)
        expected.append(wind_up)
    found = moves(frame(angles, order=order), turning(1))[wind_up_column(1, travel)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_a_table_with_last_moves_alone_has_no_wind_up():
    """Former versions wrote the last moves of a subset without the wind-up: these moves are kept, and no wind-up is made up from what is left."""
    table = frame([0.0, 1.0, 0.5])
    of_whole = moves(table, turning(1))
    former = table.assign(**{name: of_whole[name] for name in last_move_columns(1)}).iloc[1:]
    found = moves(former, turning(1))
    assert found[step_column(1)].tolist() == of_whole[step_column(1)][1:].tolist()
    assert not found[wind_up_column(1, TRAVELS[0])].any()


def test_a_part_of_a_dataset_keeps_the_moves_of_the_whole():
    """Subsets, and subsets of these, keep the move to each pose even without the pose before; its columns are no covariates."""
    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=8).dataset
    whole = moves(dataset.poses, turning(6))
    rows = np.array([1, 4, 5, 11, 20])
    part = dataset.subset(rows).subset(np.array([0, 2, 4]))
    seen = Poses.from_frame(part.poses, turning(6), order_is_row=True).columns
    for name, values in whole.items():
        np.testing.assert_array_equal(seen[name], values[rows[[0, 2, 4]]])
    assert part.covariates == dataset.covariates


def test_a_prediction_without_an_order_has_no_moves():
    """Poses to predict for have moves only if their order is stated."""
    table = make_scene(kind="tracker", seed=2, poses_per_plane=4).dataset.poses.drop(
        columns=["order"], errors="ignore"
    )
    assert step_column(1) not in Poses.from_frame(table, turning(6), order_is_row=False).columns
    ordered = table.assign(order=np.arange(len(table)))
    assert step_column(1) in Poses.from_frame(ordered, turning(6), order_is_row=False).columns


def test_the_moves_of_a_subset_are_written_and_read(tmp_path):
    """A part written as a folder and read again has the same moves."""
    from scalar.data.dataset import read_dataset

    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=8).dataset
    part = replace(dataset.subset(np.array([1, 4, 5, 11, 20])), source="")
    part.write(tmp_path / "part")
    again = moves(read_dataset(tmp_path / "part").poses, turning(6))
    for name, values in moves(part.poses, turning(6)).items():
        np.testing.assert_allclose(again[name], values, rtol=0, atol=1e-12)


def test_the_velocity_in_passing_needs_times_and_both_neighbours():
    """It goes from the pose before to the pose after, over their times; at both ends, after a gap and without times it is not known."""
    table = pd.DataFrame(
        {"q1": [0.0, 0.1, 0.4, 0.4, 0.5], "order": [0, 1, 2, 4, 5], "time": [0.0, 1.0, 4.0, 5.0, 6.0]}
    )
    np.testing.assert_allclose(moves(table, turning(1))[passing_column(1)], [0.0, 0.1, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(
        moves(table.drop(columns="time"), turning(1))[passing_column(1)], np.zeros(5)
    )
