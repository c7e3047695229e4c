"""Curves over a joint are looked for only where it takes many positions."""

from dataclasses import replace

import numpy as np

from scalar.effects.acquisition import LEAST_LEVELS, swept_joints
from scalar.effects.flexible.proposals import flexible_terms
from scalar.effects.flexible.shape import UnattributedShape
from scalar.effects.flexible.wave import UnattributedWave
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from tests.random_scene import make_scene


def on_grid(levels: int):
    """Return a tracked dataset whose fourth joint takes a few positions; the encoder's last digits scatter."""
    dataset = make_scene("vs060", "tracker", seed=2, poses_per_plane=20).dataset
    rng = np.random.default_rng(1)
    angles = np.linspace(-1, 1, levels)[
        rng.integers(levels, size=dataset.n_poses)
    ] + 1e-5 * rng.standard_normal(dataset.n_poses)
    return replace(dataset, poses=dataset.poses.assign(q4=angles))


def curves_over_joint_4(dataset):
    """Return the harmonics, waves and shapes of joint 4 over its own angle."""
    found = [*JointHarmonic.candidates(dataset), *flexible_terms(dataset)]
    return [
        e
        for e in found
        if isinstance(e, JointHarmonic | UnattributedWave | UnattributedShape) and e.own_angle_joint == 4
    ]


def test_a_scale_error_on_a_grid_may_be_an_error_once_a_turn():
    """Where no harmonics are looked for, a scale error may stand for one; where they are, the data tell."""
    for levels, alike in ((LEAST_LEVELS // 2, ["joint_harmonic"]), (2 * LEAST_LEVELS, [])):
        dataset = on_grid(levels)
        assert [e.name for e in JointScale(4).alike_at_few_positions(dataset)] == alike
        assert not JointScale(3).alike_at_few_positions(dataset)
    assert not JointScale(4, slides=True).alike_at_few_positions(on_grid(LEAST_LEVELS // 2))


def test_a_joint_on_a_grid_has_no_curve():
    """Half as many positions as are wanted show no curve, twice as many do; the other joints are swept in both."""
    few, many = on_grid(LEAST_LEVELS // 2), on_grid(2 * LEAST_LEVELS)
    assert swept_joints(few) == [1, 2, 3, 5, 6] and swept_joints(many) == [1, 2, 3, 4, 5, 6]
    assert not curves_over_joint_4(few) and curves_over_joint_4(many)
