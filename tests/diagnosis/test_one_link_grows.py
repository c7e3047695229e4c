"""Where one link alone grows with the temperature, the growth is not called one of all lengths."""

import numpy as np
import pytest

from scalar.diagnosis.diagnose import diagnose
from scalar.effects.flexible.growth import UnattributedGrowth
from tests.effects.injected import A, Flaws, PoseData, make_cell

LINK = 3  # the longest of the arm
GROWTH = 1e-4  # 1/K, a gear motor at the end of the link included
SWING = 6.0  # K


def swinging(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return the temperature of a link that is warmed and cooled twice."""
    return {"temperature": 24.0 + SWING * np.sin(4 * np.pi * np.arange(n_poses) / n_poses)}


def with_growth(seed: int, links: list[int], growth: float):
    """Return a dataset in which the lengths a of some links (from 1) grow with that temperature."""
    truth = make_cell(seed=seed, poses_per_plane=3).scene.truth
    lengths = np.zeros_like(truth.geometry)
    for link in links:
        lengths[A, link - 1] = truth.geometry[A, link - 1]

    def grown(at: PoseData) -> np.ndarray:
        return growth * (at.columns["temperature"] - 24.0)[:, None, None] * lengths

    return make_cell(
        Flaws(geometry=grown), seed=seed, poses_per_plane=40, points_per_scan=20, columns=swinging
    ).dataset


@pytest.mark.parametrize("seed", [410, *(pytest.param(s, marks=pytest.mark.slow) for s in range(411, 414))])
def test_the_link_is_described_and_no_growth_of_all_is_named(seed):
    """What is found has no name, varies with the temperature, and is a change of that link."""
    found = diagnose(with_growth(seed, [LINK], GROWTH))
    assert found.verdict == "unattributed"
    assert not [f.effect.name for f in found.findings if f.has_name]
    (term,) = [f.effect for f in found.findings]
    assert isinstance(term, UnattributedGrowth)
    assert (term.joint, term.depends_on) == (LINK, ["temperature"])
    assert "between joints 2 and 3 alone" in term.described_as
