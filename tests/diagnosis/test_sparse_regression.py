"""All groups of columns beside the noise of the poses, in one model: what is planted is found, and noise is not taken for it."""

import numpy as np
import pytest
from scipy import linalg

from scalar.diagnosis.sparse_regression import SparseRegression, _Inverse, sparse_regression

N, M, GROUPS, WIDTH = 50, 3, 150, 2


def drawn(seed: int, planted: int, jitter: float = 0.0):
    """Return rows, Q, groups and common directions: groups of equal size are planted, poses err along their direction, rows have unit noise."""
    rng = np.random.default_rng(seed)
    Q = np.linalg.qr(rng.normal(size=(N * M, 12)))[0]
    groups = [100.0 * rng.normal(size=(N * M, WIDTH)) for _ in range(GROUPS)]
    which = rng.choice(GROUPS, planted, replace=False)
    along = rng.normal(size=(N, M, 1))
    rows = rng.normal(size=(N, M)) + jitter * along[:, :, 0] * rng.normal(size=(N, 1))
    r = rows.ravel() + sum(0.1 * groups[k] @ (1.0, -1.0) for k in which)
    return (r - Q @ (Q.T @ r)).reshape(N, M), Q, groups, [along], set(which.tolist())


def surest(found: SparseRegression, count: int) -> set[int]:
    """Return the most significant groups."""
    return {int(k) for k in found.kept[np.argsort(-found.significance)[:count]]}


@pytest.mark.parametrize("seed", range(6))
def test_what_one_after_the_other_would_hide_is_found_together(seed):
    """Eight groups of equal strength, each an eighth of a scatter a hundred times the noise, are the most significant ones."""
    rows, Q, groups, common, planted = drawn(seed, planted=8)
    assert surest(sparse_regression(rows, Q, groups, common, 0.25), 8) == planted


def test_the_scatter_of_the_poses_is_a_variance_of_its_own():
    """Where poses err along their direction and nothing else is there, most of it is found as their variance."""
    found = [sparse_regression(*drawn(seed, planted=0, jitter=5.0)[:4], 0.25) for seed in range(20)]
    # The standard error of a standard deviation from 50 draws is a tenth; groups take up a part of the scatter.
    assert np.sqrt(np.mean([f.pose_variances[0] for f in found])) == pytest.approx(5.0, rel=0.25)


def test_scatter_and_groups_are_told_apart():
    """Four groups beside poses that err: these groups are the most significant ones, and the variance is that of the poses."""
    for seed in range(4):
        rows, Q, groups, common, planted = drawn(seed, planted=4, jitter=5.0)
        found = sparse_regression(rows, Q, groups, common, 0.25)
        assert surest(found, 4) == planted
        assert np.sqrt(found.pose_variances[0]) == pytest.approx(5.0, rel=0.5)


def test_a_change_of_basis_within_groups_and_of_their_length_changes_nothing():
    """A group is a space, not its columns, as long as its coefficients may be large."""
    rows, Q, groups, common, _ = drawn(3, planted=5)
    mixing = np.array([[200.0, 100.0], [-100.0, 300.0]])
    groups = [1e3 * group for group in groups]
    one = sparse_regression(rows, Q, groups, common, 0.25)
    other = sparse_regression(rows, Q, [group @ mixing for group in groups], common, 0.25)
    assert set(one.kept) == set(other.kept)
    np.testing.assert_allclose(other.significance, one.significance, rtol=1e-6)


def test_groups_that_the_model_explains_are_left_out():
    """A group within Q has nothing left and is no finding; without any group the variances alone are found."""
    rows, Q, _, common, _ = drawn(4, planted=0)
    found = sparse_regression(rows, Q, [Q[:, :2]], common, 0.25)
    assert len(found.kept) == 0
    assert found.variance == pytest.approx(1.0, abs=0.3)


def test_a_group_that_cannot_be_as_large_is_not_taken():
    """What only an implausibly large coefficient would explain is no finding: columns are those of the largest plausible one."""
    rows, Q, groups, common, planted = drawn(6, planted=1)
    (k,) = planted
    tiny = [1e-4 * group for group in groups]
    assert k in sparse_regression(rows, Q, groups, common, 0.25).kept
    assert len(sparse_regression(rows, Q, tiny, common, 0.25).kept) == 0


def test_a_direction_in_which_no_pose_can_err_is_no_noise():
    """Where a common direction is zero (an axis that the sensor does not see), everything else is found as without it."""
    rows, Q, groups, common, planted = drawn(7, planted=3)
    found = sparse_regression(rows, Q, groups, [*common, np.zeros_like(common[0])], 0.25)
    assert surest(found, 3) == planted
    assert found.pose_variances[1] == 0.0


def test_hardly_any_noise():
    """A group whose coefficients the data determine to twelve digits is found, and nothing is lost to rounding."""
    rows, Q, groups, common, _ = drawn(8, planted=0)
    r = 1e-7 * rows.ravel() + 1e4 * groups[5] @ (1.0, 1.0)
    found = sparse_regression((r - Q @ (Q.T @ r)).reshape(N, M), Q, [1e6 * g for g in groups], common, 1e-20)
    assert surest(found, 1) == {5}
    assert np.all(np.isfinite(found.significance))


@pytest.mark.parametrize("groups_taken", [3, 60])
def test_the_inverse_given_what_the_model_explains_is_that_of_restricted_likelihood(groups_taken):
    """With flat priors, P is Z (Z' C Z)^-1 Z', Z being a basis of what Q leaves (Patterson and Thompson 1971), be columns fewer than rows or not."""
    rows, Q, groups, common, _ = drawn(5, planted=0)
    K = common[0] @ np.swapaxes(common[0], 1, 2)
    X, r = 0.01 * np.concatenate(groups[:groups_taken], axis=1), rows.ravel()
    g = np.linspace(0.5, 2.0, X.shape[1])
    B = 0.7 * np.eye(M) + 1.3 * K
    C = (X * g) @ X.T + linalg.block_diag(*B)
    Z = linalg.null_space(Q.T)
    expected = Z @ np.linalg.solve(Z.T @ C @ Z, Z.T)
    for inverse in (_Inverse.of, _Inverse._by_rows, _Inverse._by_columns):
        found = inverse(B, X, g, Q, r)
        np.testing.assert_allclose(found.r, expected @ r, atol=1e-9)
        np.testing.assert_allclose(found.X, expected @ X, atol=1e-9)
        np.testing.assert_allclose(
            linalg.block_diag(*found.blocks), expected * linalg.block_diag(*np.ones_like(B)), atol=1e-9
        )
