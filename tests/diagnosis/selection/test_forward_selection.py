"""Forward selection: when a candidate replaces an effect of the model."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.selection import forward_selection
from scalar.diagnosis.selection.forward_selection import reconsidered
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.command_line import parse_effects
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, make_cell, on_joint, sag

SMALL = 4e-5  # rad: micrometres, which add less than a hundredth to the root mean square of points held out


@pytest.mark.parametrize("seed", [3, 4, 6])
def test_a_rival_is_compared_under_the_same_whitening(seed, monkeypatch):
    """Order 2 of joint 2 was injected. Order 7 of joint 4, whose evidence is overstated here, leaves the error of joint 2 as a variance component of
    whole poses. Under the whitening of the state its squared residual is larger, and the injected effect is kept.
    """
    error = on_joint(2, lambda at: SMALL * np.sin(2 * at.q[:, 1] + 0.4))
    dataset = make_cell(Flaws(joints=error), seed=seed, points_per_scan=300).dataset
    model, prepared = geometry_fit(dataset)
    right, wrong = (parse_effects(name, dataset) for name in ("joint_harmonic:2:2", "joint_harmonic:4:7"))
    state = refit(dataset, model, prepared.free, right)
    rival = state.refitted(wrong)
    assert (
        rival.background_whitened_by(state.whitening).sum_of_squares > 1.1 * state.background().sum_of_squares
    )
    honest = forward_selection.rivals

    def overstated(state, i, columns, within):
        own, ranking = honest(state, i, columns, within)
        return own, [replace(own, effect=wrong[0], evidence=own.evidence + 100.0), *ranking]

    monkeypatch.setattr(forward_selection, "rivals", overstated)
    kept, _ = reconsidered(state, named_candidates(dataset))
    assert [effect.target for effect in kept.effects] == [right[0].target]


@pytest.mark.parametrize("seed", [13, 15, 16])
def test_what_a_further_term_explains_as_well_is_no_further_cause(seed):
    """Joints 2 and 3 have a compliance. A scale error of joint 2 explains its share as well, but it would be a second cause; a further joint of the
    compliance is chosen instead.
    """
    truth = make_cell(seed=seed, poses_per_plane=3).scene.truth
    flaws = Flaws(joints=sag(truth, np.array([0, 3e-6, 3e-6, 0, 0, 0]), np.random.default_rng(seed)))
    dataset = make_cell(flaws, seed=seed, poses_per_plane=25).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    both = [e for name in ("joint_scale:2", "joint_compliance:3") for e in parse_effects(name, dataset)]
    state = refit(dataset, model, prepared.free, both)
    kept, _ = reconsidered(state, named_candidates(dataset))
    assert [(effect.name, effect.target) for effect in kept.effects] == [
        ("joint_compliance", {"joints": [2, 3]})
    ]


def test_a_candidate_that_is_pushed_out_again_is_not_added_for_ever(monkeypatch):
    """Of two candidates, the better one is dropped as soon as it is in the model: it is tried once, and the other one is then found."""

    def fitted(*labels: str) -> Any:
        return SimpleNamespace(
            is_rounding=False,
            settings=DEFAULTS,
            effects=tuple(SimpleNamespace(label=label) for label in labels),
        )

    tried: list[str] = []

    def with_best(state: Any, columns: None, refused: set[str]) -> tuple[Any, str] | None:
        present = [effect.label for effect in state.effects]
        label = next((label for label in ("better", "other") if label not in {*refused, *present}), None)
        if label is None:
            return None
        tried.append(label)
        return fitted(*present, label), label

    def without_better(state: Any, candidates: None) -> tuple[Any, None]:
        return fitted(*(effect.label for effect in state.effects if effect.label != "better")), None

    monkeypatch.setattr(forward_selection, "CandidateColumns", SimpleNamespace(of=lambda *_: None))
    monkeypatch.setattr(forward_selection, "_with_best_candidate", with_best)
    monkeypatch.setattr(forward_selection, "reconsidered", without_better)
    found = forward_selection.select_forward(fitted("first"), None)  # type: ignore[arg-type]
    assert [effect.label for effect in found.effects] == ["first", "other"]
    assert tried == ["better", "other"]
