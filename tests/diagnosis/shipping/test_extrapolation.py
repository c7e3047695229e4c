"""What few moves of the joints show is found, and is not corrected where nothing was measured."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.diagnosis.accuracy.expected_errors import ExpectedErrors
from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.held_out.hold_out import held_out_errors
from scalar.diagnosis.shipping.focused_choice import FocusedChoice, focused_choice
from scalar.diagnosis.shipping.nested_models import LIMITS
from scalar.diagnosis.shipping.shipped_fit import BEFORE, EQUAL, shipped_fit
from scalar.effects.joint_scale import JointScale
from scalar.errors import Undetermined
from scalar.estimation.geometry_fit import geometry_fit
from scalar.evaluate.pose_errors import best_rigid_motion
from scalar.evaluate.workspace_errors import Banded
from scalar.geometry.robot import Tolerance
from scalar.report import beyond_ranges
from scalar.report.shipped_words import shipped_sentences
from tests.effects.injected import Flaws, make_cell, on_joint
from tests.estimation.test_data_sheet_priors import GEAR, as_tracked, grid, rms, stating, workcell
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def scaled() -> FittedState:
    """Return the fit without effects of a workcell whose joint 3 has a scale error."""
    flaws = Flaws(joints=on_joint(3, lambda at: 1e-3 * at.q[:, 2]))
    dataset = make_cell(flaws, seed=77, points_per_scan=20, poses_per_plane=20).dataset
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, ())


@pytest.mark.parametrize(
    ("error", "std_without", "decided_by"),
    [(1.9, 0.0, "only_one"), (2.1, 0.0, "extrapolation"), (2.1, 1.2, "only_one")],
)
def test_a_correction_that_may_err_far_more_than_the_arm_is_not_shipped(
    monkeypatch, scaled, error, std_without, decided_by
):
    """The expected error is at most twice that of the model without effects at held-out poses, or twice the standard error of its predictions.

    ``error`` and ``std_without`` are in units of the error at held-out poses.
    """
    rms = held_out_errors(scaled).rms
    monkeypatch.setattr(
        "scalar.diagnosis.shipping.shipped_fit.focused_choice",
        lambda state, _: replace(
            focused_choice(state), errors_as_chosen=(error * rms,) * 3, std_without=std_without * rms
        ),
    )
    shipped = shipped_fit(scaled, scaled.refitted([JointScale(3)]), None)
    assert shipped.decided_by == decided_by
    assert shipped.fit == (EQUAL if decided_by == "only_one" else BEFORE)


@pytest.mark.parametrize("determined", [True, False])
def test_nothing_is_corrected_where_the_tolerance_stands_in_for_poses(scaled, determined):
    """If the poses do not determine the geometry, the model without effects is shipped, and the effects remain findings."""
    shipped = shipped_fit(scaled, scaled.refitted([JointScale(3)]), None, geometry_determined=determined)
    assert shipped.without_effects == (not determined)
    assert (shipped.decided_by == "undetermined_geometry") == (not determined)


@pytest.mark.parametrize(
    ("decided_by", "words"),
    [
        ("undetermined_geometry", ("to the data sheet", "differ in all joints")),
        (
            "extrapolation",
            ("over the whole of the joint limits", "7.2 mm", "0.26 mm RMS", "all over the workspace"),
        ),
    ],
)
def test_why_nothing_is_corrected_is_said(scaled, decided_by, words, monkeypatch):
    """The sentence says that the effects are findings only, why, and which poses would change that."""
    state: Any = None
    choice = FocusedChoice(
        state, (), (), 7.2e-3, (7.2e-3, 1e-4, 1e-4), errors_without=(3e-4,) * 3, std_without=0.0
    )
    stated = ExpectedErrors(*(Banded(3e-4, 1e-4, 9e-4),) * 2)
    monkeypatch.setattr(beyond_ranges, "expected_errors", lambda _: stated)
    shipped = SimpleNamespace(
        regions=None,
        without_effects=True,
        decided_by=decided_by,
        choice=choice,
        held_out=SimpleNamespace(rms=2.6e-4),
        disagreement=None,
        unconfirmed=(),
    )
    cleaned = SimpleNamespace(dataset=make_scene().dataset)
    diagnosis: Any = SimpleNamespace(
        shipped=shipped,
        outer=None,
        halves=None,
        findings=(),
        cleaned=cleaned,
        before=scaled,
        errors_after={"unseen_rms_mm": None, "held_out_rms_mm": 0.26},
    )
    text = " ".join(shipped_sentences(diagnosis))
    assert "findings only" in text and all(word in text for word in words)


@pytest.mark.slow
@pytest.mark.parametrize("stated", [True, False])
def test_on_a_grid_of_two_joints_errors_of_the_geometry_are_no_effects(stated):
    """Small moves of the other joints do not determine the geometry, which the maker's tolerance does then, or one estimated from the arm."""
    dataset, _ = workcell(2, grid(5))
    diagnosis = diagnose(stating(dataset) if stated else dataset)
    assert diagnosis.verdict == "no_effect"
    assert diagnosis.calibration_after.model.priors


def test_expected_errors_contain_what_the_data_sheet_may_err():
    """Off a grid, predictions err as much as is expected: leaving out poses alone would not show this error."""
    dataset, truth = workcell(3, grid(6))
    diagnosis = diagnose(dataset)
    rng = np.random.default_rng(4)
    q = rng.uniform(*dataset.robot.limits.T, (2000, 6))
    predicted = as_tracked(diagnosis.calibration_after, q)
    T = best_rigid_motion(predicted, truth(q))
    errs = rms(predicted @ T[:3, :3].T + T[:3, 3] - truth(q))
    expected = diagnosis.shipped.choice.errors_without[LIMITS]
    assert errs / 3 < expected < 3 * errs


@pytest.mark.slow
def test_what_a_grid_shows_is_found_and_not_corrected():
    """Gear errors of the two joints that move are named at these joints or without a name, and the geometry alone is shipped."""
    dataset, _ = workcell(1, grid(5), gear=2 * GEAR)
    diagnosis = diagnose(stating(dataset))
    assert diagnosis.findings and diagnosis.verdict != "no_effect"
    sure = [f.effect.target.get("joint") for f in diagnosis.findings if f.has_name and f.confidence >= 0.8]
    assert set(sure) <= {2, 3}
    assert diagnosis.shipped.decided_by == "undetermined_geometry"
    assert not diagnosis.calibration_after.model.effects


def test_a_tolerance_does_not_replace_equations():
    """Fifteen poses give fewer equations than a model has unknowns: a diagnosis refuses them whatever tolerance is stated."""
    dataset = make_scene(poses_per_plane=5, points_per_scan=10, seed=2).dataset
    dataset = replace(dataset, robot=replace(dataset.robot, tolerance=Tolerance(5e-4, 5e-4)))
    with pytest.raises(Undetermined, match="15 poses give 30 equations for 32 unknowns") as refusal:
        geometry_fit(dataset)
    assert "a diagnosis needs the poses" in str(refusal.value)
