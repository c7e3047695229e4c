"""A residual with a pattern is not reported as noise: a growth, or a loose sensor, is random for each pose by itself."""

import numpy as np
import pytest

from scalar.diagnosis.diagnose import diagnose
from scalar.report.noise_card import noise_clause
from tests.effects.injected import A, D, Flaws, make_cell, on_joint, true_frames


def sawtooth_growth(truth):
    """All lengths grow by 6e-4 over 45 poses and shrink back: cycles of warming and pausing."""

    def geometry(at):
        lengths = np.zeros_like(truth.geometry)
        lengths[[A, D]] = truth.geometry[[A, D]]
        return 6e-4 * ((at.order / 45.0 + 0.3) % 1.0 - 0.5)[:, None, None] * lengths

    return Flaws(geometry=geometry)


def loose_mount(truth):
    """The sensor lies 0.15 mm to one side of its play or to the other, as gravity pulls it."""

    def motion(at):
        T = true_frames(truth, Flaws(), at, np.zeros_like(at.q))
        side = np.clip(-T[:, 2, 0] / 0.1, -1.0, 1.0)
        M = np.tile(np.eye(4), (len(T), 1, 1))
        M[:, :3, 3] = T[:, :3, 2] * (1.5e-4 * side)[:, None]
        return M

    return Flaws(base=motion)


@pytest.mark.parametrize(("pattern", "depends"), [(sawtooth_growth, ["order"]), (loose_mount, ["gravity"])])
@pytest.mark.parametrize("seed", [0, pytest.param(2, marks=pytest.mark.slow)])
def test_a_pattern_is_unattributed_and_says_what_it_depends_on(pattern, depends, seed):
    """No candidate describes either cause; each is unattributed, with the columns on which it depends."""
    truth = make_cell(seed=seed, poses_per_plane=3).scene.truth
    cell = make_cell(pattern(truth), seed=seed, poses_per_plane=34)
    content = diagnose(cell.dataset).to_mapping()
    assert content["verdict"] == "unattributed"
    assert [effect["name"] for effect in content["effects"]] == ["unattributed"]
    assert content["effects"][0]["depends_on"] == depends


@pytest.mark.parametrize(
    "flaws",
    [Flaws(jitter=1e-4), pytest.param(Flaws(bias=1e-4), marks=pytest.mark.slow)],
    ids=["jitter", "bias"],
)
def test_a_noise_is_no_pattern(flaws):
    """Independent errors of the poses are named as noise or not at all; a small jitter may go unnoticed with 75 poses."""
    for seed in (10, 11):
        content = diagnose(make_cell(flaws, seed=seed, poses_per_plane=25).dataset).to_mapping()
        assert content["verdict"] != "unattributed"
        assert {effect["name"] for effect in content["effects"]} <= {"pose_jitter", "scan_bias"}


@pytest.mark.parametrize("joint", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_one_joint_that_scatters_is_no_jitter_of_all(joint):
    """If one joint scatters from pose to pose by an unknown cause, the scatter has no name, and its entry names that joint."""
    errors = np.random.default_rng(joint).normal(0.0, 4e-4, 1000)
    flaws = Flaws(joints=on_joint(joint, lambda at: errors[: len(at.q)]))
    diagnosis = diagnose(make_cell(flaws, seed=60 + joint, poses_per_plane=30).dataset)
    (effect,) = diagnosis.to_mapping()["effects"]
    assert effect["name"] == "unattributed"
    assert diagnosis.noise_place == f"q{joint}" and f"q{joint}" in effect["depends_on"]
    assert f"as if the position of joint {joint} alone erred" in noise_clause(diagnosis)
