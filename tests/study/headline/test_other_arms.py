"""What other arms need fixed follows from their axes: one length more for a third parallel axis, and no more than the original's list else."""

import numpy as np
import pandas as pd
import pytest
from study.headline.other_arms import arms_numbers, arms_table

from scalar.geometry.robot import Robot
from scalar.robots import read_arm

PUBLISHED = ["d_6", "theta_6", "d_2", "a_1", "alpha_1", "theta_1", "d_1"]


@pytest.fixture(scope="module")
def table():
    """Return the table for a scanner somewhere on the flange."""
    T = np.eye(4)
    T[:3, 3] = [-0.1, -0.03, 0.1]
    return arms_table(T, PUBLISHED).set_index("arm")


def parallel_pairs(name):
    """Return how many pairs of successive joints of an arm have parallel axes."""
    robot = Robot.from_mapping(read_arm(name).mapping)
    frames = robot.frames(np.full((1, robot.n_joints), 0.3))[0]
    axes = frames[-robot.n_joints :, :3, 2]
    return int(np.sum(np.abs(np.sum(axes[:-1] * axes[1:], axis=1)) > 1 - 1e-9))


def test_each_pair_of_parallel_axes_adds_a_direction(table):
    """Base and flange account for six directions, and each pair of successive parallel axes for one."""
    assert {name: 6 + parallel_pairs(name) for name in table.index} == dict(table["zero_singular_values"])


def test_the_original_s_list_leaves_what_it_lacks(table):
    """With the original's list fixed, as many directions stay as an arm has more than it has entries; lists are equal where none stays."""
    left = table["zero_singular_values"] - len(PUBLISHED)
    assert list(table["left_by_published"]) == list(left)
    assert list(table["same_set"]) == list(left == 0)
    assert table.loc["denso_vs060", "same_set"]
    assert "panda" not in " ".join(table.index)


def test_numbers_count_the_table():
    """The numbers are counts and names of the table."""
    rows = pd.DataFrame(
        {
            "arm": ["a", "b", "c"],
            "maker": ["A", "A", "B"],
            "zero_singular_values": [7, 7, 8],
            "held": ["d_1 d_2", "d_2 d_1", "d_1 d_2 d_3"],
            "same_set": [True, True, False],
        }
    )
    assert arms_numbers(rows) == {
        "arms": 3,
        "makers": 2,
        "same_set": 2,
        "others": 1,
        "others_makers": ["B"],
        "others_hold_also": ["d_3"],
        "others_zero_singular_values": [8],
    }
