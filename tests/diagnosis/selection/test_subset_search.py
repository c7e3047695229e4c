"""The search of sets of effects: its algebra agrees with least squares, its optimum with all sets, and it finds what was injected."""

from itertools import combinations

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.selection.beam_search import SearchElements, Subset
from scalar.diagnosis.selection.subset_search import best_subset
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, make_cell


def elements_of(E: np.ndarray, r: np.ndarray, widths: list[int]) -> SearchElements:
    """Return elements with columns of these widths, in units of priors and noise."""
    columns = np.split(np.arange(E.shape[1]), np.cumsum(widths)[:-1])
    largest = np.full(E.shape[1], 10.0)
    return SearchElements(
        columns, np.arange(len(widths)), E.T @ E, E.T @ r, float(r @ r), len(r), len(widths), 0.2, largest
    )


def subset(elements: SearchElements, some: tuple[int, ...]) -> Subset:
    """Return one set."""
    return elements.subsets([some])[0]


def drawn(
    seed: int, rows: int = 80, widths: tuple[int, ...] = (1, 2, 3, 1, 2, 1, 2, 1)
) -> tuple[SearchElements, np.ndarray, np.ndarray]:
    """Return elements that partly resemble one another, and a residual with three of them in it."""
    rng = np.random.default_rng(seed)
    E = rng.normal(size=(rows, sum(widths))) + rng.normal(size=(rows, 1))
    c = np.zeros(E.shape[1])
    c[[0, 4, 9]] = 3.0
    r = E @ c + rng.normal(size=rows)
    return elements_of(E, r, list(widths)), E, r


@pytest.mark.parametrize("seed", range(3))
def test_the_squared_residual_of_a_set_is_that_of_the_penalised_fit(seed):
    """With a prior of unit variance on every coefficient, it is what a least-squares solver finds."""
    elements, E, r = drawn(seed)
    where = np.concatenate([elements.columns[p] for p in (0, 2, 6)])
    rows = np.vstack([E[:, where], np.eye(len(where))])
    wanted = np.linalg.lstsq(rows, np.r_[r, np.zeros(len(where))])[1][0]
    assert subset(elements, (0, 2, 6)).sum_of_squares == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_extensions_are_ranked_as_the_sets_that_they_lead_to(seed):
    """The best extension of a set is the one with which the set has the most evidence."""
    elements, _, _ = drawn(seed)
    start = subset(elements, (1, 3))
    first = elements.extensions([start], most=8)[0][0]
    every = [tuple(sorted((1, 3, p))) for p in range(len(elements.columns)) if p not in (1, 3)]
    assert first == max(every, key=lambda some: subset(elements, some).evidence)


@pytest.mark.parametrize("seed", range(3))
def test_sets_that_are_worked_out_together_are_those_worked_out_alone(seed):
    """Sets computed together, and their extensions, are those computed alone, in the given order, whatever their numbers of columns."""
    elements, _, _ = drawn(seed)
    every = [some for size in (3, 0, 2) for some in combinations(range(8), size)]
    together = elements.subsets(every)
    assert [found.elements for found in together] == every
    alone = [subset(elements, some) for some in every]
    np.testing.assert_allclose([s.evidence for s in together], [s.evidence for s in alone], rtol=1e-12)
    assert elements.extensions(together, most=4) == [elements.extensions([s], most=4)[0] for s in together]


@pytest.mark.parametrize("seed", range(5))
def test_no_set_has_more_evidence_than_the_one_that_is_found(seed):
    """The set that is found has the most evidence of all sets of eight elements."""
    elements, _, _ = drawn(seed)
    every = [some for size in range(9) for some in combinations(range(8), size)]
    best = max(every, key=lambda some: subset(elements, some).evidence)
    assert elements.best() == best


def test_an_exchange_leaves_a_set_that_imitates():
    """Two elements that together imitate a third are replaced by it."""
    rng = np.random.default_rng(7)
    true = rng.normal(size=200)
    halves = rng.permutation(200) < 100
    E = 50 * np.column_stack([np.where(halves, true, 0.3 * true), np.where(halves, 0.3 * true, true), true])
    elements = elements_of(E, E[:, 2] + rng.normal(size=200), [1, 1, 1])
    assert elements.exchanged(subset(elements, (0, 1))).elements == (2,)


@pytest.mark.parametrize("seed", range(5))
def test_an_implausibly_large_coefficient_explains_nothing(seed):
    """An element that points along the whole residual, as a range scale does, is left out if its coefficient would be too large for an effect."""
    _, E, r = drawn(seed)
    shrinking = E @ np.linalg.lstsq(E, r)[0] / 50
    for factor, wanted in ((1.0, False), (10.0, True)):  # coefficients of 50 and 5 prior standard deviations
        elements = elements_of(
            30 * np.column_stack([E, factor * shrinking]), 30 * r, [1, 2, 3, 1, 2, 1, 2, 1, 1]
        )
        assert (8 in elements.best()) == wanted


def state_of(flaws: Flaws, seed: int, **options: object) -> FittedState:
    """Return a workcell fitted without effects."""
    dataset = make_cell(flaws, seed=seed, **options).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    return refit(dataset, model, prepared.free, ())


def test_a_change_is_found_between_the_moments_of_the_coarse_search(monkeypatch):
    """If the first search tries few beginnings, the second tries all poses near the one that was found, and finds the right one."""
    slip = np.eye(4)
    slip[:3, 3] = 0.4e-3, -0.3e-3, 0.5e-3
    state = state_of(Flaws(slip=(37, slip)), seed=21, poses_per_plane=30)
    monkeypatch.setattr("scalar.diagnosis.selection.subset_search.FIRST_MOMENTS", 9)
    found = best_subset(state, named_candidates(state.dataset))
    assert [effect.name for effect in found] == ["sensor_slip"]
    assert abs(found[0].target["at"]["order"] - 37) <= 1


def test_nothing_is_found_where_nothing_is():
    """With noise alone, no effect is found."""
    for seed in range(31, 35):
        state = state_of(Flaws(), seed=seed, poses_per_plane=20)
        assert best_subset(state, named_candidates(state.dataset)) == ()


def test_the_search_starts_anew_from_a_state_with_effects():
    """Wrong effects of a state are replaced, because the set is chosen anew at its optimum."""
    gear = lambda at: np.column_stack([8e-4 * np.sin(3 * at.q[:, 0]), np.zeros((len(at.q), 5))])  # noqa: E731
    state = state_of(Flaws(joints=gear), seed=41, poses_per_plane=25)
    wrong = state.refitted([JointScale(5)])
    found = best_subset(wrong, named_candidates(state.dataset))
    assert [(effect.name, effect.target) for effect in found] == [
        ("joint_harmonic", {"joint": 1, "order": 3})
    ]
