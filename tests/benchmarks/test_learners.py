"""Learned compensation predicts what depends on the joint angles, leaves noise alone, and is judged on poses that no half shares."""

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.diagnosis.learners import Network, Process, _forward, _gradient
from benchmarks.diagnosis.measured import BLOCKS, halves, left_by, rms

FRAME = np.eye(3)[None]


def error(q):
    """Return a smooth error of the position ``(N, 3)`` [m]."""
    return 1e-3 * np.column_stack([np.sin(q[:, 0]), np.cos(q[:, 1]), np.sin(q[:, 0] + q[:, 1])])


@pytest.mark.parametrize("planes", [False, True], ids=["tracker", "contacts"])
@pytest.mark.parametrize("learner", ["process", "network"])
def test_a_smooth_error_is_learned(planes, learner):
    """Most of a smooth error is predicted at angles that were not seen, from three components or from one along many normals."""
    rng = np.random.default_rng(4)
    q = rng.uniform(-2, 2, (400, 2))
    normals = rng.standard_normal((400, 1, 3))
    d = normals / np.linalg.norm(normals, axis=2, keepdims=True) if planes else np.repeat(FRAME, 400, axis=0)
    y = np.einsum("pmi,pi->pm", d, error(q)) + 5e-5 * rng.standard_normal(d.shape[:2])
    seen, unseen = slice(0, 300), slice(300, None)
    fitted = (
        Process(q[seen], d[seen], y[seen])
        if learner == "process"
        else Network(q[seen], d[seen], y[seen], np.arange(300) // 10, rng)
    )
    left = y[unseen] - fitted.predicted(q[unseen], d[unseen])
    assert np.sqrt(np.mean(left**2)) < 0.3 * np.sqrt(np.mean(y[unseen] ** 2))


def test_noise_is_not_learned():
    """Noise, which does not depend on the angles, is left as it is, to a tenth of its size."""
    rng = np.random.default_rng(5)
    q, y = rng.uniform(-2, 2, (150, 3)), 1e-3 * rng.standard_normal((150, 3))
    d = np.repeat(FRAME, 150, axis=0)
    for learner in (Process(q, d, y), Network(q, d, y, np.arange(150) // 8, rng)):
        assert np.sqrt(np.mean(learner.predicted(q[:40] + 0.5, d[:40]) ** 2)) < 3e-4


def test_the_gradient_agrees_with_differences():
    """The gradient by every array of weights agrees with central differences of the mean squared residual."""
    rng = np.random.default_rng(6)
    x, y = rng.standard_normal((7, 4)), rng.standard_normal((7, 2))
    d = rng.standard_normal((7, 2, 3))
    weights = [rng.standard_normal(shape) for shape in ((4, 5), (5,), (5, 5), (5,), (5, 3), (3,))]

    def loss():
        return np.mean((np.einsum("pmi,pi->pm", d, _forward(weights, x)[-1]) - y) ** 2)

    for w, g in zip(weights, _gradient(weights, x, d, y), strict=True):
        place = np.unravel_index(int(np.argmax(np.abs(g))), g.shape)
        ends = []
        for step in (1e-6, -2e-6):
            w[place] += step
            ends.append(loss())
        w[place] += 1e-6
        assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(g[place], rel=1e-6)


def test_the_halves_share_no_pose():
    """Blocks of successive poses alternate between the halves, and a repetition of a pose is in the half of the first such pose."""
    q = np.random.default_rng(7).uniform(-1, 1, (200, 6))
    q[150:190] = q[:40]
    block, first = halves(q)
    assert set(block) == set(range(BLOCKS))
    assert np.array_equal(first[150:190], first[:40])
    assert 0.35 < first.mean() < 0.65
    assert np.array_equal(first, block % 2 == 0)


def test_targets_are_learned_one_by_one():
    """Two targets on one flange whose errors are opposite are both learned to a third of their size or less."""
    rng = np.random.default_rng(8)
    q = rng.uniform(-2, 2, (300, 2))
    y = np.column_stack([error(q), -error(q)]) + 2e-5 * rng.standard_normal((300, 6))
    d = np.broadcast_to(np.tile(np.eye(3), (2, 1)), (300, 6, 3))
    seen, unseen = slice(0, 200), slice(200, None)
    for learn in (
        lambda directions, residual: Process(q[seen], directions, residual),
        lambda directions, residual: Network(q[seen], directions, residual, np.arange(200) // 10, rng),
    ):
        left = left_by(learn, (y[seen], d[seen]), (y[unseen], d[unseen]), q[unseen])
        assert left.shape == (100, 6)
        assert rms(left) < 0.3 * rms(y[unseen])


def test_every_target_counts_as_a_point():
    """The error is a distance of points in mm: of one component along a normal, of a tracked point, and of each of two points of a pose."""
    assert rms(np.array([[3e-3], [-3e-3]])) == pytest.approx(3.0)
    assert rms(np.array([[3e-3, 0.0, 4e-3]])) == pytest.approx(5.0)
    assert rms(np.array([[3e-3, 0.0, 4e-3, 0.0, 5e-3, 0.0]])) == pytest.approx(5.0)
    assert rms(np.zeros((0, 3))) is None


def test_the_table_of_measured_arms_is_that_of_the_summary():
    """Each campaign of the committed summary has its row in the description of the benchmark, with the same errors to two places."""
    root = Path(__file__).parents[2]
    sets = json.loads((root / "paper/summaries/measured/rivals.json").read_text(encoding="utf-8"))["sets"]
    page = (root / "benchmarks/diagnosis/README.md").read_text(encoding="utf-8")
    for name, found in sets.items():
        (row,) = [line for line in page.splitlines() if line.startswith(f"| `{name}` |")]
        told = [
            ", ".join(f"{half[f'{method}{where}_mm']:.2f}" for half in found["halves"])
            for where in ("", "_within")
            for method in ("geometry", "diagnosis", "gaussian_process", "network")
        ]
        assert [cell.strip() for cell in row.split("|")[2:-1]] == told
