"""Candidate sets: columns are computed once for a state, and the candidates of a pool count wherever its parts stand."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.column_products import Rows, one_joint_each
from scalar.diagnosis.fit.effect_columns import Bases
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.held_arrays import held_bytes
from scalar.diagnosis.scoring import candidate_columns, conditional_scores
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, CandidateSet, named_candidates
from scalar.diagnosis.scoring.conditional_scores import background_without, rivals
from scalar.diagnosis.structure import ranked_terms
from scalar.effects.flexible.arm_step import UnattributedArmStep
from scalar.effects.flexible.variable import Variable
from scalar.effects.joint_scale import JointScale
from scalar.effects.plane_moved import PlaneMoved
from scalar.estimation.geometry_fit import geometry_fit
from tests.random_scene import make_scene


def test_columns_are_kept_for_their_state_and_set(monkeypatch):
    """The same state and set return the same object, and any other state or set another one; beyond the limit of memory nothing is kept."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, ())
    pool, other_pool = (CandidateSet.of([JointScale(joint)]) for joint in (2, 3))
    kept = CandidateColumns.of(state, pool)
    assert CandidateColumns.of(state, pool) is kept
    other_state = state.refitted([JointScale(4)])
    for columns in (CandidateColumns.of(state, other_pool), CandidateColumns.of(other_state, pool)):
        assert columns is not kept
        assert not np.array_equal(columns.products.squared_lengths, kept.products.squared_lengths)
    monkeypatch.setattr(candidate_columns, "_MOST_KEPT", 0)
    third = state.refitted([JointScale(5)])
    assert CandidateColumns.of(third, pool) is not CandidateColumns.of(third, pool)


def test_a_candidate_and_its_rivals_are_corrected_for_the_same_number():
    """An effect of the state, scored among its rivals, has the score of the same candidate, also if further candidates are in other sets."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, (JointScale(2),))
    for elsewhere in (0, 40):
        pool = CandidateSet.of([JointScale(2), JointScale(3)], elsewhere=elsewhere)
        own, others = rivals(state, 0, CandidateColumns.of(state, pool))
        same = next(score for score in others if score.effect.same_answer(own.effect))
        assert own.evidence == pytest.approx(same.evidence, abs=1e-6)
        assert own.p_value == pytest.approx(same.p_value, rel=1e-6)


def test_what_was_ranked_is_not_ranked_again(monkeypatch):
    """Rivals and flexible terms in an effect's place are the same when asked for again, without another ranking, and a caller may change its list."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, (JointScale(2),))
    pool = CandidateSet.of([JointScale(2), JointScale(3)])
    columns = CandidateColumns.of(state, pool)
    background = background_without(state, [0])[0]
    own, others = rivals(state, 0, columns)
    terms = ranked_terms.ranked_once(state, [background], [pool])
    for module in (conditional_scores, ranked_terms):
        monkeypatch.setattr(module, "rank", None)
    again = list(others)
    others.clear()
    assert rivals(state, 0, columns) == (own, again)
    assert ranked_terms.ranked_once(state, [background, background], [pool]) == 2 * terms
    assert background_without(state, [0])[0] is background


def test_without_an_effect_no_further_pass_over_the_rows_is_needed():
    """Scores in the place of an effect follow from products with the whole model: they are those that the rows without the effect give."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, (JointScale(2), JointScale(4)))
    columns = CandidateColumns.of(state, named_candidates(dataset))
    left_out = background_without(state, [0])[0]
    from_rows = replace(left_out, left_out=None)
    assert left_out.left_out is not None and left_out.left_out.whole is columns.full
    pairs = [
        *zip(columns.conditional(left_out).values(), columns.conditional(from_rows).values(), strict=True)
    ]
    for short, long in pairs:
        for name in ("grams", "projections", "share"):
            expected = getattr(long, name)
            np.testing.assert_allclose(getattr(short, name), expected, atol=1e-9 * np.abs(expected).max())
    changes = [*zip(columns.changes(left_out), columns.changes(from_rows), strict=True)]
    assert pairs and changes
    for (_, short), (_, long) in changes:
        np.testing.assert_allclose(short.gain, long.gain, rtol=1e-7, atol=1e-9)
        np.testing.assert_array_equal(short.dof, long.dof)


def test_columns_given_another_model_are_what_it_leaves_of_them():
    """For a model with one more column at the same optimum, products are those of the columns less what it spans; the state's own stay."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, ())
    pool = CandidateSet.of([JointScale(2), JointScale(3)])
    columns, own = CandidateColumns.of(state, pool), state.background()
    before = columns.conditional(own)[1]
    residual, jacobian = state.linearised()
    added = np.zeros((len(residual), 1))
    added[: own.residual.size] = state.columns_of([JointScale(4)])
    larger = Background.of(
        residual, np.column_stack([jacobian, added]), *own.residual.shape, state.settings.score_test
    )
    instead = columns.given(larger).conditional(larger)[1]
    E = state.columns_of(pool.elements)
    left = E - larger.Q @ (larger.Q.T @ E)
    shares = np.sum(left**2, axis=0) / np.sum(E**2, axis=0)
    np.testing.assert_allclose(instead.share[:, 0], shares, rtol=1e-9)
    np.testing.assert_allclose(
        instead.projections[:, 0] / columns.candidates.prior_std * larger.variance,
        E.T @ larger.residual.ravel(),
        rtol=1e-9,
    )
    assert np.all(instead.share < before.share)
    np.testing.assert_array_equal(columns.conditional(own)[1].grams, before.grams)


def test_shares_of_an_effect_on_points_are_computed_once_for_all_states(monkeypatch):
    """With the bases of a set, another state asks no effect again how it acts in the course of the poses, and its columns are those without."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    moved = [
        effect.beginning(order, None) for effect, _ in PlaneMoved.changes(dataset) for order in (9.0, 20.0)
    ]
    first = refit(dataset, model, prepared.free, ())
    second, bases = first.refitted([JointScale(2)]), Bases()
    first.columns_of(moved, bases)
    expected = second.columns_of(moved)
    monkeypatch.setattr(PlaneMoved, "constant_and_shares", None)
    np.testing.assert_array_equal(second.columns_of(moved, bases), expected)


def test_products_of_columns_are_those_of_the_columns_themselves():
    """Inner products within candidates and with any rows are those of the columns that ``columns_of`` forms, of one joint, of several, or of none."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, (JointScale(2),))
    pool = named_candidates(dataset)
    E = state.columns_of(pool.elements)
    products = state.products_of(pool.elements, pool.groups.values(), Bases())
    assert len(products.blocks) > 2
    rows = np.random.default_rng(0).standard_normal((len(E), 4))
    lengths = np.linalg.norm(E, axis=0)
    np.testing.assert_allclose(products.squared_lengths, lengths**2, rtol=1e-12)
    limit = 1e-12 * lengths.max() * np.linalg.norm(rows)
    np.testing.assert_allclose(products.with_rows(Rows(rows)), E.T @ rows, rtol=0, atol=limit)
    kept = Rows(rows, keep=True)
    for _ in range(2):  # the second time from components that are known
        np.testing.assert_array_equal(products.with_rows(kept), products.with_rows(Rows(rows)))
    for groups in pool.groups.values():
        own = E.T[groups]
        limit = 1e-12 * lengths.max() ** 2
        np.testing.assert_allclose(products.grams(groups), own @ np.swapaxes(own, 1, 2), rtol=0, atol=limit)


def test_bases_that_are_forgotten_are_computed_again():
    """The bases of a set are kept until they are forgotten; the products of columns are the same bit for bit afterwards."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state, pool = refit(dataset, model, prepared.free, ()), named_candidates(dataset)
    first = state.products_of(pool.elements, pool.groups.values(), pool.bases)
    assert held_bytes(pool.bases, set()) > 0 and pool.bases.of_products
    pool.bases.forget()
    assert not pool.bases and not pool.bases.of_products
    again = state.products_of(pool.elements, pool.groups.values(), pool.bases)
    np.testing.assert_array_equal(first.squared_lengths, again.squared_lengths)


def test_steps_of_a_link_have_the_columns_of_their_basis():
    """Steps of one link at several moments, whose columns are computed together, each have those that their own basis gives."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, ())
    clock = Variable.observed("order", np.arange(float(dataset.n_poses)))
    steps = [UnattributedArmStep(joints, clock, at) for at in (-0.4, 0.3) for joints in ((2,), (5,))]
    by_geometry = state.residuals.linearise_measured(state.model)[1][:, state.model.blocks["geometry"]]
    by_geometry = by_geometry.reshape(dataset.n_poses, -1, by_geometry.shape[1])
    bases = [step.geometry_basis(dataset.robot, dataset.known_poses) for step in steps]
    expected = [by_geometry @ basis.reshape(*by_geometry.shape[::2], -1) for basis in bases]
    found = state.columns_within_scans(steps).reshape(*by_geometry.shape[:2], -1)
    np.testing.assert_allclose(found, np.concatenate(expected, axis=2), rtol=1e-12, atol=1e-12)


def test_a_column_stays_with_its_joint_unless_a_group_joins_it_to_another():
    """Groups that span joints take their columns out of them, and so do groups that share a column with such a group."""
    joints = np.array([0, 0, 1, 1, 1, 2, -1])
    assert (
        one_joint_each(joints, [np.array([[0], [5], [6]]), np.array([[0, 1], [2, 3]])]).tolist()
        == joints.tolist()
    )
    chained = one_joint_each(joints, [np.array([[0, 1], [3, 4]]), np.array([[1, 2], [2, 3]])])
    assert chained.tolist() == [-1, -1, -1, -1, -1, 2, -1]


def test_rivals_within_a_margin_are_the_first_of_all():
    """If candidates that explain far less are left out, the others are as they are among all."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, (JointScale(2),))
    columns = CandidateColumns.of(state, named_candidates(dataset))
    own, others = rivals(state, 0, columns)
    margin = own.evidence - others[4].evidence
    near = [entry for entry in others if entry.evidence >= own.evidence - margin]
    assert 4 < len(near) < len(others)
    found = rivals(state, 0, columns, within=margin)
    assert (found[0], [(s.effect.key, s.evidence) for s in found[1]]) == (own, [(s.effect.key, s.evidence) for s in near])  # fmt: skip
