"""Two halves of the poses: when they are diagnosed, what they decide, and how they limit a confidence."""

from __future__ import annotations

import sys
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.held_out.hold_out import HeldOutErrors, held_out_errors
from scalar.diagnosis.held_out.outer_split import OuterSplit
from scalar.diagnosis.held_out.repeated_runs import Answer
from scalar.diagnosis.naming.two_halves import (
    confidence_by_halves,
    limited_by_halves,
    residuals_are_correlated,
    two_halves,
)
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from scalar.report.unseen_words import unseen_sentences
from tests.diagnosis.cases import scale
from tests.diagnosis.stand_ins import finding_of
from tests.effects.injected import Flaws, make_cell, on_joint

DIAGNOSE = sys.modules["scalar.diagnosis.diagnose"]  # the package's own name for it is the function
LEAST = DEFAULTS.naming.least_confidence


def fitted(flaws: Flaws) -> FittedState:
    """Return 120 poses fitted without effects."""
    dataset = make_cell(flaws, seed=5, poses_per_plane=40, points_per_scan=20).dataset
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, ())


def halves_of(errors: HeldOutErrors, factors: tuple[float, float], chosen: tuple[bool, ...]) -> OuterSplit:
    """Return two halves with errors in proportion to given ones, without and with effects, with the runs that found the scale error of joint 4."""
    without, effects = (replace(errors, metric=errors.metric * factor**2) for factor in factors)
    answers = tuple(Answer(None, None, (JointScale(4),) if one else (), None) for one in chosen)  # type: ignore[arg-type]
    level = float(np.mean(errors.metric))
    return OuterSplit(2, answers, (), (without, effects), np.arange(len(errors.metric)) % 2, (level, level))


def test_independent_residuals_need_no_halves():
    """With noise alone, residuals of similar poses are not correlated; with a joint's error that the model lacks, they are."""
    assert not residuals_are_correlated(fitted(Flaws()))
    assert residuals_are_correlated(
        fitted(Flaws(joints=on_joint(3, lambda at: 1e-3 * np.sin(3 * at.q[:, 2]))))
    )


@pytest.mark.parametrize(("effects", "equations", "judged"), [(1, 80, True), (0, 80, False), (1, 79, False)])
def test_halves_judge_what_was_chosen_from_enough_poses(monkeypatch, effects, equations, judged):
    """No halves are run without effects, or if a half has fewer than four equations for each of ten parameters, because it then shows no effects."""
    module = sys.modules["scalar.diagnosis.naming.two_halves"]
    monkeypatch.setattr(module, "residuals_are_correlated", lambda state: True)
    monkeypatch.setattr(module, "moving_joints", lambda state: None)
    monkeypatch.setattr(module, "outer_split", lambda *_: SimpleNamespace(answers=("one", "other")))
    monkeypatch.setattr(module, "distinct_equations", lambda state: state.equations)
    before = SimpleNamespace(equations=equations, free=np.ones(10, dtype=bool))
    found: Any = SimpleNamespace(
        before=before, after=SimpleNamespace(effects=(None,) * effects), cleaned=None
    )
    assert (two_halves(None, found, None, DEFAULTS, 1) is not None) == judged  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("chosen", "most"), [((True, True), 1.0), ((True, False), 0.5), ((False, False), 0.25)]
)
def test_the_confidence_is_limited_by_the_halves(chosen, most):
    """The confidence has no limit if both halves found the effect, one half if one did, and a quarter, so that the name is doubtful, if none did."""
    errors = HeldOutErrors(np.ones(8), np.ones(8), np.ones(8), np.arange(8))
    halves = halves_of(errors, (1.0, 1.0), chosen)
    assert confidence_by_halves(halves.selected_in(JointScale(4)), halves) == pytest.approx(most)
    (limited,) = limited_by_halves([finding_of(JointScale(4), 0.97)], halves, LEAST)
    assert limited.confidence == pytest.approx(min(0.97, most)) and limited.doubtful == (most < LEAST)


@pytest.mark.parametrize(
    ("factors", "fit", "stated"), [((4.0, 3.0), "equal_weights", 3.0), ((4.0, 5.0), "before", None)]
)
def test_the_stated_error_is_that_of_the_halves_where_it_is_larger(monkeypatch, factors, fit, stated):
    """If the halves predict each other better with the effects, these are shipped with the error of the halves, corrected for the number of poses. If
    worse, the model without effects is shipped with its own held-out error, because nothing in it was selected.
    """
    found: dict[str, Any] = {}

    def halves(dataset, run, answer, settings, cores):
        errors = held_out_errors(run.after)
        found["halves"] = halves_of(errors, factors, (True, True))
        return found["halves"]

    monkeypatch.setattr(DIAGNOSE, "two_halves", halves)
    diagnosis = diagnose(scale(3, poses_per_plane=20, points_per_scan=12)[0].dataset)
    mapping = diagnosis.to_mapping()
    error = mapping["residual"]["after"]["held_out_rms_mm"]
    assert mapping["shipped"]["fit"] == fit
    held_out = 1e3 * diagnosis.shipped.held_out.rms
    if stated is None:
        assert mapping["shipped"]["decided_by"] == "unseen" and error == pytest.approx(held_out)
    else:
        seen = diagnosis.calibration_after.residual_rms
        assert error == pytest.approx(1e3 * found["halves"].unseen_rms(1, seen)) and error > 2 * held_out
    first, *_ = unseen_sentences(diagnosis, mapping)
    assert "on each half of the poses" in first
