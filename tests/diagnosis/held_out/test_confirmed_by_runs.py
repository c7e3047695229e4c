"""A diagnosis with an outer split: what its runs confirm, what is corrected nevertheless, and which errors are stated."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jsonschema
import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.diagnosis import diagnose
from scalar.diagnosis.explained import Explained
from scalar.diagnosis.held_out.repeated_runs import Answer
from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.settings import DEFAULTS, Settings
from scalar.effects import Effect
from scalar.effects.joint_scale import JointScale
from scalar.effects.sensor_slip import SensorSlip
from scalar.report import render_report
from tests.diagnosis.cases import scale
from tests.diagnosis.held_out.runs import corrects_wrongly, geometry_alone, one_scale
from tests.effects.injected import Flaws, PoseData, make_cell

DIAGNOSE = sys.modules["scalar.diagnosis.diagnose"]  # the package's own name for it is the function
SCHEMA = json.loads((Path(__file__).parents[1] / "diagnosis.schema.json").read_text())


@pytest.mark.parametrize("most", [119, 120])
def test_parts_are_diagnosed_in_the_way_of_the_whole(most, monkeypatch):
    """Whole sets of effects are compared in the parts only if they are compared in the whole, although each part has few enough poses for it."""
    dataset = scale(5, poses_per_plane=40)[0].dataset
    asked: list[int] = []

    def geometry_and_settings(part: Dataset, settings: Settings) -> Answer:
        asked.append(settings.subset_search.most_poses)
        return geometry_alone(part, settings)

    monkeypatch.setattr(DIAGNOSE, "answer_without", geometry_and_settings)
    settings = replace(DEFAULTS, subset_search=replace(DEFAULTS.subset_search, most_poses=most))
    diagnose(dataset, settings=settings, outer_folds=2, cores=1)
    assert set(asked) == {most if most == 120 else 0}


@pytest.mark.slow
def test_what_no_run_confirms_is_no_finding(monkeypatch):
    """An effect that the runs do not find is listed as not confirmed, with little confidence, and is not in after.json."""
    dataset = scale(5, poses_per_plane=40)[0].dataset
    monkeypatch.setattr(DIAGNOSE, "answer_without", geometry_alone)
    diagnosis = diagnose(dataset, outer_folds=2)
    mapping = diagnosis.to_mapping()
    jsonschema.validate(mapping, SCHEMA)
    entry = mapping["not_confirmed"][0]
    assert (
        not mapping["effects"]
        and entry["name"] == "joint_scale"
        and entry["selected_in"] == 0.0
        and entry["confidence"] < 0.5
    )
    assert mapping["verdict"] == "no_effect" and not diagnosis.calibration_after.model.effects
    assert "Not confirmed" in render_report(diagnosis)


def test_the_error_of_runs_that_correct_is_not_that_of_a_file_without_effects(monkeypatch):
    """Where nothing was found, after.json is the fit without effects, and its error at unseen poses is that of the runs' fits without effects."""
    monkeypatch.setattr(DIAGNOSE, "answer_without", corrects_wrongly)
    diagnosis = diagnose(make_cell(seed=61, poses_per_plane=30, points_per_scan=12).dataset, outer_folds=2)
    before, after = (
        diagnosis.to_mapping()["residual"][when]["unseen_rms_mm"] for when in ("before", "after")
    )
    assert not diagnosis.findings and diagnosis.outer.unseen_rms(1, 0.0) > diagnosis.outer.unseen_rms(0, 0.0)
    assert after == before
    assert "without effects; at most" not in render_report(diagnosis)


@pytest.mark.slow
def test_an_unconfirmed_effect_without_which_predictions_are_worse_is_corrected_all_the_same(monkeypatch):
    """Joints 2 and 3 have a scale error, and the runs of the outer split find that of joint 3 alone. The other is no finding; after.json has both,
    and report and diagnosis.json say so.
    """

    def scales(at: PoseData) -> np.ndarray:
        return at.q * [0.0, 2e-3, 2e-3, 0.0, 0.0, 0.0]

    dataset = make_cell(Flaws(joints=scales), seed=5, poses_per_plane=40, points_per_scan=12).dataset
    monkeypatch.setattr(DIAGNOSE, "answer_without", one_scale)
    diagnosis = diagnose(dataset, outer_folds=2)
    mapping = diagnosis.to_mapping()
    jsonschema.validate(mapping, SCHEMA)
    assert [e["target"] for e in mapping["effects"]] == [{"joint": 3}]
    assert [e["target"] for e in mapping["not_confirmed"]] == [{"joint": 2}]
    assert mapping["shipped"]["unconfirmed"] == [{"name": "joint_scale", "target": {"joint": 2}}]
    corrected = {effect.target["joint"] for effect in diagnosis.calibration_after.model.effects}
    assert corrected == {2, 3} and mapping["residual"]["after"]["train_rms_mm"] < 0.1
    page = render_report(diagnosis)
    assert (
        page.count("also corrects for") == 1
        and "are predicted worse" in page
        and "does not correct for it" not in page
    )


def test_an_unconfirmed_change_at_a_moment_is_not_corrected(monkeypatch):
    """A slip that no run chose is left out, although held-out poses of either part are predicted better with it; a scale that helps is kept."""
    effects = (JointScale(3), JointScale(2), SensorSlip(30.0))
    found = tuple(Finding(e, 1e-9, None, None, (), 0.9, (), None) for e in effects)  # type: ignore[arg-type]

    def fit(of: Sequence[Effect]) -> Any:
        return SimpleNamespace(effects=tuple(of), settings=DEFAULTS, is_plausible=True, refitted=fit)

    monkeypatch.setattr(DIAGNOSE, "near_data_sheet", lambda state: state)
    monkeypatch.setattr(DIAGNOSE, "unconfirmed_effects_help", lambda without, everything: True)
    outer: Any = SimpleNamespace(answers=(None,), selected_in=lambda effect: float(effect is effects[0]))
    run, kept, refused = DIAGNOSE._confirmed(
        Explained(None, None, fit(effects), fit(effects), None), found, outer
    )  # type: ignore[arg-type]
    assert run.after.effects == effects[:2]
    assert [f.effect for f in kept] == [effects[0]] and [f.effect for f in refused] == [*effects[1:]]


@pytest.mark.slow
def test_every_run_selects_anew():
    """A strong effect is found in every run; with it the errors on unseen poses are smaller, and no smaller than those in training."""
    diagnosis = diagnose(scale(5, poses_per_plane=40)[0].dataset, outer_folds=3)
    mapping = diagnosis.to_mapping()
    jsonschema.validate(mapping, SCHEMA)
    assert [(e["name"], e["selected_in"]) for e in mapping["effects"]] == [("joint_scale", 1.0)]
    before, after = (mapping["residual"][when] for when in ("before", "after"))
    assert after["train_rms_mm"] < after["unseen_rms_mm"] < 0.7 * before["unseen_rms_mm"]
    assert after["unseen_rms_mm"] < after["unseen_max_mm"] and after["unseen_rms_spread_mm"] > 0


def test_a_quick_answer_says_so():
    """Without the outer split its numbers are null, and the report says that they are not known."""
    diagnosis = diagnose(make_cell(seed=62, poses_per_plane=20, points_per_scan=12).dataset)
    mapping = diagnosis.to_mapping()
    jsonschema.validate(mapping, SCHEMA)
    for when in ("before", "after"):
        assert mapping["residual"][when]["unseen_rms_mm"] is None
    assert mapping["outer_split"] is None and "This is a quick answer" in render_report(diagnosis)
