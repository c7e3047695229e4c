"""The exchange algorithm: updates agree with inverses, the criterion never grows, and small sets are as good as the best of all subsets."""

from itertools import combinations

import numpy as np
import pytest

from scalar.planning.exchange import Design, add_best, exchange


def problem(seed, n=14, m=2, parameters=4):
    """Return rows of candidates, weak initial information and a matrix B of lower rank for the criterion A."""
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((n, m, parameters)) * rng.uniform(0.2, 3.0, (n, 1, 1))
    columns = rng.standard_normal((3, parameters))
    return rows, 1e-4 * np.eye(parameters), columns.T @ columns


def covariance(rows, start, chosen):
    """Return the covariance of a set, directly."""
    A = rows[list(chosen)].reshape(-1, rows.shape[2])
    return np.linalg.inv(start + A.T @ A)


def value(rows, start, interest, chosen):
    """Return the criterion of a set, directly."""
    C = covariance(rows, start, chosen)
    return np.linalg.slogdet(C)[1] if interest is None else np.trace(interest @ C)


@pytest.mark.parametrize("a_optimal", [True, False])
def test_gains_and_losses_are_those_of_the_sets_themselves(a_optimal):
    """Gains and losses are the differences of the criterion between a set and the same set with one candidate more or less."""
    rows, start, interest = problem(1)
    interest = interest if a_optimal else None
    design = Design.of(rows, start, interest, [0, 3, 5, 8])
    others = design.others()
    here = value(rows, start, interest, design.chosen)
    more = [here - value(rows, start, interest, [*design.chosen, i]) for i in others]
    np.testing.assert_allclose(design.gains(others), more, rtol=1e-8)
    fewer = [value(rows, start, interest, [j for j in design.chosen if j != i]) - here for i in design.chosen]
    np.testing.assert_allclose(design.losses(np.array(design.chosen)), fewer, rtol=1e-6)


def test_updates_agree_with_inverses():
    """After adding and removing candidates, the updated covariance is the inverse of the set's information."""
    rows, start, interest = problem(2)
    design = Design.of(rows, start, interest)
    for i in (1, 4, 7, 2, 9):
        design.add(i)
    for i in (4, 9):
        design.remove(i)
    np.testing.assert_allclose(design.covariance, covariance(rows, start, [1, 7, 2]), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("a_optimal", [True, False])
@pytest.mark.parametrize("seed", range(5))
def test_exchange_never_worsens_and_ends_where_no_exchange_helps(seed, a_optimal):
    """From a random set the criterion never grows, and at the end no swap of the cheapest candidate lowers it."""
    rows, start, interest = problem(seed)
    interest = interest if a_optimal else None
    chosen = [int(i) for i in np.random.default_rng(seed).permutation(len(rows))[:6]]
    design = Design.of(rows, start, interest, chosen)
    before = design.value
    exchange(design)
    assert design.value <= before + 1e-9 * abs(before)
    assert len(set(design.chosen)) == 6
    assert design.value == pytest.approx(value(rows, start, interest, design.chosen), rel=1e-8)
    for out in design.chosen:
        kept = [i for i in design.chosen if i != out]
        for into in design.others():
            swapped = value(rows, start, interest, [*kept, into])
            assert swapped >= design.value - 1e-7 * abs(design.value)


@pytest.mark.parametrize("a_optimal", [True, False])
def test_small_sets_are_as_good_as_the_best_subset(a_optimal):
    """Greedy choice and exchange find the best of all subsets, or one within 2 % of it (for D, 2 % of the volume's fourth root)."""
    best_found = 0
    for seed in range(10):
        rows, start, interest = problem(seed)
        interest = interest if a_optimal else None
        design = Design.of(rows, start, interest)
        add_best(design, 5)
        exchange(design)
        best = min(value(rows, start, interest, s) for s in combinations(range(len(rows)), 5))
        if a_optimal:
            assert best - 1e-9 <= design.value <= 1.02 * best
        else:
            assert best - 1e-9 <= design.value <= best + 4 * np.log(1.02)
        best_found += design.value <= best + 1e-6 * abs(best)
    assert best_found >= 6


def test_poses_that_are_fixed_stay():
    """The first poses of a design, which may be measured already, are not exchanged."""
    rows, start, interest = problem(3)
    design = Design.of(rows, start, interest, [0, 1, 2, 3, 4])
    exchange(design, fixed=2)
    assert {0, 1} <= set(design.chosen)


def test_the_only_pose_that_determines_a_direction_cannot_be_removed():
    """A candidate that alone determines a direction has an infinite loss."""
    rows = np.zeros((3, 1, 2))
    rows[0, 0, 0] = rows[1, 0, 0] = 1e8
    rows[2, 0, 1] = 1e8
    design = Design.of(rows, 1e-6 * np.eye(2), np.eye(2), [0, 1, 2])
    losses = design.losses(np.array([0, 2]))
    assert np.isfinite(losses[0])
    assert np.isinf(losses[1])


@pytest.mark.parametrize("a_optimal", [True, False])
def test_every_group_keeps_its_least_number(a_optimal):
    """Whatever an exchange would gain, no plane falls below its least number of poses."""
    rows, start, interest = problem(6, n=30)
    groups = np.repeat([0, 1, 2], 10)
    rows[groups == 2] *= 0.01
    design = Design.of(rows, start, interest if a_optimal else None, [], groups, 2)
    add_best(design, 9)
    exchange(design)
    assert len(design.chosen) == 9
    assert np.bincount(groups[design.chosen], minlength=3).min() == 2
