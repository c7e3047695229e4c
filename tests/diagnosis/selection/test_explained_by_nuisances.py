"""Effects of the arm that only describe what every set-up has to a small degree: bowed planes, an inexact zero of the scanner."""

from types import SimpleNamespace

import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.scoring.ranking import Scored
from scalar.diagnosis.selection import explained_by_nuisances as nuisances
from scalar.diagnosis.selection import forward_selection
from scalar.diagnosis.selection.explained_by_nuisances import explained_by_nuisances
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.effect import Effect
from scalar.effects.joint_coupling import JointCoupling
from scalar.effects.joint_scale import JointScale
from scalar.effects.plane_bow import PlaneBow
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, make_cell, on_joint

BENT = {"floor": (8e-4, 0.0, 8e-4), "wall_x": (8e-4, 0.0, 8e-4), "wall_y": (8e-4, 0.0, 8e-4)}


def fitted(flaws: Flaws, *effects, seed: int = 4):
    """Return the state of a workcell with some effects, and the candidates."""
    dataset = make_cell(flaws, seed=seed, poses_per_plane=20).dataset
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, effects), named_candidates(dataset)


@pytest.mark.parametrize("seed", [4, 5])
def test_a_scale_error_that_stands_for_bows_is_replaced_by_them(seed):
    """The planes are bowed, and joint 2 has no error: what is left are bows alone."""
    state, candidates = fitted(Flaws(bent=BENT), JointScale(2), seed=seed)
    assert abs(state.effects[0].coefficients[0]) > 0
    found = explained_by_nuisances(state, candidates)
    assert {effect.name for effect in found.effects} == {"plane_bow"}


def test_a_scale_error_beside_bows_stays():
    """Joint 2 errs by a thousandth, and the planes are bowed as well: the scale error explains more than any bows can."""
    flaws = Flaws(bent=BENT, joints=on_joint(2, lambda at: 1e-3 * at.q[:, 1]))
    state, candidates = fitted(flaws, JointScale(2))
    assert "joint_scale" in {effect.name for effect in explained_by_nuisances(state, candidates).effects}


def test_a_single_bow_does_not_take_the_place_of_an_effect(monkeypatch):
    """Where only one of three planes is bowed, a scale error that the bow explains as well is not replaced by it."""
    state, candidates = fitted(Flaws(bent={"floor": BENT["floor"]}), JointScale(2))
    assert explained_by_nuisances(state, candidates) is state
    monkeypatch.setattr(nuisances, "_most_are_there", lambda *_: True)
    assert [effect.target for effect in explained_by_nuisances(state, candidates).effects] == [
        {"plane": "floor"}
    ]


def test_an_effect_of_the_arm_does_not_take_the_place_of_a_bow(monkeypatch):
    """A scale error with four nats more evidence than the bow of a plane does not replace it; with nine it does.

    In place of a coupling, four are enough, and two are not.
    """
    state, _ = fitted(Flaws(bent=BENT))
    bow, coupling = PlaneBow.candidates(state.dataset)[0], JointCoupling(5, 4)
    scale = JointScale(2)

    def is_replaced(own: Effect, more: float) -> bool:
        entries = [
            Scored(effect, 1.0, 1, nats, 0.0, 1.0) for effect, nats in ((own, 50.0), (scale, 50.0 + more))
        ]
        trial = SimpleNamespace(
            background_whitened_by=lambda _: SimpleNamespace(sum_of_squares=1.0),
            is_plausible=True,
            effects=(),
        )
        given = SimpleNamespace(
            settings=DEFAULTS,
            dataset=state.dataset,
            whitening=None,
            background=lambda: SimpleNamespace(sum_of_squares=1.0, degrees_of_freedom=1),
            refitted=lambda _: trial,
        )
        return forward_selection._replaced(given, (), entries[0], entries) is trial

    monkeypatch.setattr(forward_selection, "held_out_errors", lambda *_: None)
    monkeypatch.setattr(forward_selection, "no_worse", lambda *_: True)
    assert not is_replaced(bow, 4.0) and is_replaced(bow, 9.0)
    assert is_replaced(coupling, 4.0) and not is_replaced(coupling, 2.0)
