"""A name that is less likely right than wrong is not given: what was found is unattributed, and its shape stays in the correction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.diagnose import describe_diagnosis
from scalar.data.declared import PlaneGuess
from scalar.diagnosis import Diagnosis, diagnose
from scalar.diagnosis.settings import DEFAULTS, NamingSettings
from scalar.report import render_report
from tests.effects.injected import Flaws, make_cell
from tests.random_scene import make_scene

SCALED = 3
STRICT = replace(DEFAULTS, naming=NamingSettings(least_confidence=1.01))  # no confidence is enough


@pytest.fixture(scope="module")
def scaled() -> Diagnosis:
    """Return the diagnosis of a joint whose angle errs in proportion, by settings to which every name is doubtful."""
    dataset = make_scene(seed=11, poses_per_plane=40, points_per_scan=16).dataset
    poses = dataset.poses.copy()
    poses[f"q{SCALED}"] = poses[f"q{SCALED}"] / 1.002
    return diagnose(replace(dataset, poses=poses), settings=STRICT)


@pytest.fixture(scope="module")
def scattered() -> Diagnosis:
    """Return the diagnosis of joints that do not repeat, by the same settings."""
    return diagnose(make_cell(Flaws(jitter=2e-4), seed=2).dataset, settings=STRICT)


def test_a_doubtful_effect_is_unattributed_and_says_what_it_is_like(scaled):
    """The entry has no name or coefficients; ``most_like`` names the joint's scale, and the two confidences add up to one."""
    (entry,) = scaled.to_mapping()["effects"]
    assert scaled.verdict == entry["name"] == "unattributed"
    assert entry["depends_on"] == [f"q{SCALED}"] and entry["target"] == entry["coefficients"] == {}
    (like,) = entry["most_like"]
    assert (like["name"], like["target"]) == ("joint_scale", {"joint": SCALED})
    assert like["confidence"] + entry["confidence"] == pytest.approx(1)
    assert not entry["corrected_by_flexible_term"]


def test_the_correction_keeps_the_shape_of_a_doubtful_effect(scaled):
    """The shipped calibration has the scale with its true size, and held-out poses are predicted at least twice as well."""
    (effect,) = scaled.calibration_after.model.effects
    assert effect.name == "joint_scale"
    assert abs(effect.coefficients[0]) == pytest.approx(0.002, rel=0.1)
    assert scaled.held_out_after.rms < 0.5 * scaled.held_out_before.rms


def test_report_and_terminal_send_nobody_to_a_repair(scaled):
    """Both say what the structure looks like, and give none of the advice that belongs to the name."""
    page, said = render_report(scaled), describe_diagnosis(scaled)
    assert "Structure most like “joint 3: " in page
    assert "Look for the cause before anything is repaired" in page
    assert "structure that no known effect explains" in said and 'most like "joint 3: ' in said
    assert not any(sentence in page for sentence in scaled.findings[0].effect.advice)


@pytest.mark.slow
def test_a_doubtful_scatter_is_unattributed(scattered):
    """The entry has no name, is most like a jitter, depends on all joints, and the report does not state a cause."""
    (entry,) = scattered.to_mapping()["effects"]
    assert scattered.verdict == entry["name"] == "unattributed"
    assert [like["name"] for like in entry["most_like"]] == ["pose_jitter"]
    assert entry["depends_on"] == [f"q{i + 1}" for i in range(scattered.dataset.robot.n_joints)]
    page = render_report(scattered)
    assert "do not show what causes it" in page and "come back to a pose only up to" not in page


def test_what_is_certain_keeps_its_name_beside_what_is_not(scaled):
    """With the usual settings the same data name the joint; the threshold decides, and nothing else changes."""
    usual = diagnose(scaled.dataset)
    (entry,) = usual.to_mapping()["effects"]
    assert (usual.verdict, entry["name"]) == ("effect", "joint_scale")
    np.testing.assert_allclose(
        usual.calibration_after.model.effects[0].coefficients,
        scaled.calibration_after.model.effects[0].coefficients,
        rtol=1e-9,
    )


def test_a_name_that_is_confounded_is_given_with_its_rivals():
    """Planes of known place show a gain of the range, but hardly whether the gain is the same at all ranges: either is likely, and both are told."""
    cell = make_cell(Flaws(measured=lambda r: r / (1 + 2e-3)), seed=13, poses_per_plane=60)
    truth = cell.scene.truth
    known = tuple(
        PlaneGuess(p.name, n, float(d), 1e-5, 1e-4)
        for p, n, d in zip(cell.dataset.planes, truth.normals, truth.distances, strict=True)
    )
    strict = replace(DEFAULTS, naming=replace(DEFAULTS.naming, least_confidence=0.8))
    (entry,) = diagnose(replace(cell.dataset, planes=known), settings=strict).to_mapping()["effects"]
    assert entry["name"] == "range_scale" and entry["confidence"] < 0.8
    assert [other["name"] for other in entry["confounded_with"]] == ["range_distortion"]
