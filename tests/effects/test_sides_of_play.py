"""The command that is printed for play calibrates the same play: by the load, by the moves, or by the direction of approach."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.effects.command_line import named_effects, parse_effects
from scalar.effects.joint_backlash import JointBacklash
from scalar.errors import InvalidInput
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def with_approach():
    """Return a dataset whose directions of approach of joint 3 are recorded."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=10, seed=3).dataset
    side = np.where(np.arange(dataset.n_poses) % 2 == 0, 1.0, -1.0)
    return replace(dataset, poses=dataset.poses.assign(approach3=side))


@pytest.mark.parametrize("by", ["approach", "moves", "torque"])
def test_the_named_play_turns_by_the_same(with_approach, by):
    """What a diagnosis prints for `--effects` means the play that it found, although directions of approach are recorded."""
    (read,) = parse_effects(named_effects([JointBacklash(3, by)]), with_approach)
    assert isinstance(read, JointBacklash) and (read.joint, read.by) == (3, by)


def test_a_joint_alone_is_calibrated_by_what_is_recorded(with_approach):
    """Without a further word, the recorded direction counts, and the load where none is recorded."""
    found = parse_effects("joint_backlash:3,joint_backlash:2", with_approach)
    assert [getattr(effect, "by", None) for effect in found] == ["approach", "torque"]


@pytest.mark.parametrize(
    ("word", "said"),
    [("weight", "write one of approach, moves, torque"), ("approach", "no column approach2")],
)
def test_a_side_that_is_not_known_is_refused(with_approach, word, said):
    """The message names what may be written, or the column that is missing."""
    with pytest.raises(InvalidInput, match=said):
        parse_effects(f"joint_backlash:2:{word}", with_approach)
