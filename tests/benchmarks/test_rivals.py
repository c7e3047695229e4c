"""The rivals of the diagnosis are what they say: the lasso's minimum, the penalty of least BIC, stability selection's bound, a Gaussian process."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.diagnosis.compensation import Compensation, squared_chords
from benchmarks.diagnosis.rivals import descended, entries, least_bic
from benchmarks.diagnosis.stability import FALSE_ONES, THRESHOLD, first_columns
from benchmarks.diagnosis.stratified import DIAGNOSIS, PROCESS, summary
from scalar.effects.joint_scale import JointScale


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.05, 0.9))
def test_descent_ends_where_the_optimality_conditions_hold(seed, share):
    """At the end, the gradient is the penalty against the sign of each nonzero coefficient, and is no larger elsewhere."""
    rng = np.random.default_rng(seed)
    A, y = rng.standard_normal((40, 8)), rng.standard_normal(40)
    A /= np.linalg.norm(A, axis=0)
    gram, correlation = A.T @ A, A.T @ y
    penalty = share * np.abs(correlation).max()
    w = descended(gram, correlation, np.zeros(8), penalty, 1e-12)
    gradient = gram @ w - correlation
    assert np.all(np.abs(gradient) <= penalty + 1e-9)
    assert gradient[w != 0] == pytest.approx(-penalty * np.sign(w[w != 0]), abs=1e-9)


def test_orthogonal_columns_are_shrunk_one_by_one():
    """With orthonormal columns the lasso is soft thresholding."""
    correlation = np.array([3.0, -2.0, 0.5])
    w = descended(np.eye(3), correlation, np.zeros(3), 1.0, 1e-12)
    assert w == pytest.approx([2.0, -1.0, 0.0])


def test_noise_is_left_alone_and_a_column_is_found():
    """Columns that have no part in the residual are not taken, and the column that makes the residual is taken with few others."""
    rng = np.random.default_rng(5)
    A = np.linalg.qr(rng.standard_normal((400, 12)))[0]
    noise = rng.standard_normal(400)
    quiet = noise - A @ (A.T @ noise)
    assert not least_bic(A.T @ A, A.T @ quiet, float(quiet @ quiet), 400).any()
    loud = quiet + 40.0 * A[:, 3]
    found = np.flatnonzero(least_bic(A.T @ A, A.T @ loud, float(loud @ loud), 400))
    assert found.tolist() == [3]
    assert least_bic(np.zeros((0, 0)), np.zeros(0), 1.0, 10).shape == (0,)


def test_entries_are_those_of_a_diagnosis():
    """The entries have the name and the target in the form that the score reads."""
    (entry,) = entries([JointScale(2)])
    assert (entry["name"], entry["target"]) == ("joint_scale", {"joint": 2})


def test_stability_selection_takes_the_strongest_columns_first():
    """Of many columns, the few that make the rows enter first, and no more than the bound allows."""
    rng = np.random.default_rng(3)
    E, J = rng.standard_normal((300, 60)), rng.standard_normal((300, 4))
    r = 5.0 * E[:, 7] - 4.0 * E[:, 20] + J @ np.ones(4) + 0.1 * rng.standard_normal(300)
    first = first_columns(E, J, r)
    assert set(first[:2]) == {7, 20}
    assert len(first) <= int(np.sqrt((2 * THRESHOLD - 1) * 60 * FALSE_ONES))


def test_a_column_of_the_model_is_never_selected():
    """A combination of the model's own columns is never selected, because it explains nothing that the model has not explained already."""
    rng = np.random.default_rng(4)
    J = rng.standard_normal((200, 3))
    E = np.column_stack([J @ [1.0, 2.0, -1.0], rng.standard_normal((200, 19))])
    assert 0 not in first_columns(E, J, rng.standard_normal(200))


def test_the_process_predicts_a_smooth_error_and_leaves_noise_alone():
    """Trained on one component of each pose, the process predicts a smooth error at other poses, and predicts almost nothing from noise."""
    rng = np.random.default_rng(6)
    q, there = rng.uniform(-1, 1, (300, 2)), rng.uniform(-1, 1, (50, 2))
    normals = np.eye(3)[np.arange(300) % 3]

    def error(at):
        return 1e-3 * np.column_stack([np.sin(at[:, 0]), np.cos(at[:, 1]), at[:, 0] * at[:, 1]])

    distances = -np.einsum("ni,ni->n", normals, error(q)) + 2e-5 * rng.standard_normal(300)
    found = Compensation(q, normals, distances).error_at(there)
    assert np.abs(found - error(there)).max() < 0.2 * np.abs(error(there)).max()
    silent = Compensation(q, normals, 1e-4 * rng.standard_normal(300)).error_at(there)
    assert np.abs(silent).max() < 5e-5


def test_angles_a_turn_apart_are_the_same_place():
    """The kernel treats two angles that differ by a full turn as the same place."""
    q = np.array([[0.3, -0.2]])
    assert squared_chords(q, q + 2 * np.pi) == pytest.approx(np.zeros((1, 1)), abs=1e-15)


def test_the_summary_compares_set_by_set():
    """Counts are of all sets. Pairs of contestants are compared by who alone answers without a fault, and by whose correction is nearer."""

    def rows(name, clean, after):
        flags = dict.fromkeys(("missed", "wrong", "worse", "much_worse"), False)
        return [
            {"number": i, "contestant": name, "clean": c, "position_after_mm": a, "seconds": 1.0}
            | {"after_over_before": a, **flags}
            for i, (c, a) in enumerate(zip(clean, after, strict=True))
        ]

    table = pd.DataFrame(
        rows(DIAGNOSIS, [True, True, False, True], [0.1, 0.2, 1.0, 0.5])
        + rows("stepwise", [True, False, True, False], [0.1, 0.3, 0.9, 0.51])
        + rows(PROCESS, [None] * 4, [1.0] * 4)
    )
    found = summary(table)
    assert found["sets"] == 4
    step = found["stepwise"]
    assert (step["clean"], step["only_diagnosis_clean"], step["only_this_clean"]) == (2, 2, 1)
    assert (step["nearer"], step["farther"]) == (1, 1)
    assert found[PROCESS]["clean"] is None and "clean_low" not in found[PROCESS]
    assert (
        found[DIAGNOSIS]["clean_share"] == 0.75
        and found[DIAGNOSIS]["clean_low"] < 0.75 < found[DIAGNOSIS]["clean_high"]
    )
    assert found[DIAGNOSIS]["nearer"] == found[DIAGNOSIS]["farther"] == 0
