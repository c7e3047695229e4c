"""An axis that wobbles while its joint turns is described as that: no coupling, no tilt of parallel axes and no base that gives way is sure."""

import numpy as np
import pytest

from scalar.diagnosis.diagnose import diagnose
from scalar.effects.flexible.wobble import UnattributedWobble
from tests.diagnosis.structure.tracked_workcell import tracked
from tests.effects.injected import ALPHA, BETA, Flaws, Function, PoseData, true_frames
from tests.random_scene import make_scene


def wobbling(joint: int, turns: int, tilt: float) -> Function:
    """Return the change of geometry by an axis that is tilted in a direction which turns with the joint.

    Args:
        joint: From 1.
        turns: Of that direction in a turn of the joint, seen from the link before; negative: against the joint.
        tilt: [rad].
    """

    def change(at: PoseData) -> np.ndarray:
        direction = turns * at.q[:, joint - 1] + 1.3
        found = np.zeros((len(at.q), 5, at.q.shape[1]))
        found[:, ALPHA, joint - 1], found[:, BETA, joint - 1] = (
            tilt * np.cos(direction),
            tilt * np.sin(direction),
        )
        return found

    return change


@pytest.mark.parametrize(
    ("robot", "joint", "turns", "seed"), [("puma560", 3, 2, 1), ("panda", 4, 2, 2), ("vs060", 5, -1, 3)]
)
def test_the_axis_that_wobbles_is_found(robot, joint, turns, seed):
    """The term is that of the joint, with the order that was injected, and no name stands for it."""
    found = diagnose(tracked(robot, Flaws(geometry=wobbling(joint, turns, 4e-4)), seed, 2e-5, 120))
    assert not [f.effect.name for f in found.findings if f.has_name]
    (term,) = [f.effect for f in found.findings]
    assert isinstance(term, UnattributedWobble)
    assert (term.joint, term.order) == (joint, abs(turns))


def test_a_wobble_of_the_first_axis_is_no_sure_base_that_gives_way():
    """A weight beside the first axis tilts a base that is stiffer about one horizontal axis in just the same way, so nothing tells the two apart."""
    found = diagnose(tracked("puma560", Flaws(geometry=wobbling(1, -1, 2e-4)), 4, 2e-5, 120))
    assert found.findings
    assert not [f.effect.name for f in found.findings if f.has_name and f.confidence >= 0.8]


def test_the_wobble_of_an_axis_moves_what_it_bears():
    """The functions of the term, at the places of the geometry where they act, move the sensor as the tilt that was injected does."""
    scene = make_scene("vs060", "tracker", seed=6, poses_per_plane=4)
    q, truth = scene.dataset.q, scene.truth
    at, still = PoseData(q, np.arange(float(len(q))), {}), np.zeros_like(q)
    basis = UnattributedWobble(3, 2).geometry_basis(scene.dataset.robot, scene.dataset.known_poses)
    tilt, direction = 1e-6, 1.3
    # tilt (cos(2 q + direction), sin(2 q + direction)) in sines and cosines of 2 q
    coefficients = tilt * np.array(
        [-np.sin(direction), np.cos(direction), np.cos(direction), np.sin(direction)]
    )
    by_term = true_frames(truth, Flaws(geometry=lambda _: basis @ coefficients), at, still)
    by_hand = true_frames(truth, Flaws(geometry=wobbling(3, 2, tilt)), at, still)
    np.testing.assert_allclose(by_term, by_hand, atol=1e-14)
