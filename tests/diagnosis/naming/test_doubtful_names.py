"""A finding whose name is more probably wrong than right is unattributed, and the correction still contains its effect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.diagnosis_words import describe_diagnosis
from scalar.data.declared import PlaneGuess
from scalar.diagnosis import Diagnosis, diagnose
from scalar.diagnosis.naming.judged_effects import _in_place_alone
from scalar.diagnosis.settings import DEFAULTS, NamingSettings
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_scale import JointScale
from scalar.report import render_report
from tests.diagnosis.stand_ins import scored
from tests.effects.injected import Flaws, make_cell
from tests.random_scene import make_scene

SCALED = 3
STRICT = replace(DEFAULTS, naming=NamingSettings(least_confidence=1.01))  # no confidence is enough


@pytest.fixture(scope="module")
def scaled() -> Diagnosis:
    """Return the diagnosis of an arm with a scale error of a joint, by settings with which every name is doubtful."""
    dataset = make_scene(seed=11, poses_per_plane=40, points_per_scan=16).dataset
    poses = dataset.poses.copy()
    poses[f"q{SCALED}"] = poses[f"q{SCALED}"] / 1.002
    return diagnose(replace(dataset, poses=poses), settings=STRICT)


@pytest.fixture(scope="module")
def scattered() -> Diagnosis:
    """Return the diagnosis of an arm whose joints do not repeat, by the same settings."""
    return diagnose(make_cell(Flaws(jitter=2e-4), seed=2).dataset, settings=STRICT)


def test_a_doubtful_effect_is_unattributed_and_says_what_it_is_like(scaled):
    """The entry has no name and no coefficients; ``most_like`` lists the joint's scale error, and the two confidences add up to one."""
    (entry,) = scaled.to_mapping()["effects"]
    assert scaled.verdict == entry["name"] == "unattributed"
    assert entry["depends_on"] == [f"q{SCALED}"] and entry["target"] == entry["coefficients"] == {}
    (like,) = entry["most_like"]
    assert (like["name"], like["target"]) == ("joint_scale", {"joint": SCALED})
    assert like["confidence"] + entry["confidence"] == pytest.approx(1)
    assert not entry["corrected_by_flexible_term"]


def test_the_correction_keeps_a_doubtful_effect(scaled):
    """The shipped calibration has the scale error with its true size, and its held-out error is at most half of that without effects."""
    (effect,) = scaled.calibration_after.model.effects
    assert effect.name == "joint_scale"
    assert abs(effect.coefficients[0]) == pytest.approx(0.002, rel=0.1)
    assert scaled.shipped.held_out.rms < 0.5 * scaled.held_out_before.rms


def test_report_and_terminal_advise_no_repair_for_a_doubtful_name(scaled):
    """Both say what the structure resembles, and give none of the advice that belongs to the name."""
    page, said = render_report(scaled), describe_diagnosis(scaled)
    assert "Structure that resembles “joint 3: " in page
    assert "Look for the cause before anything is repaired" in page
    assert (
        "structure without a certain name" in said
        and "Structure without a certain name" in page
        and 'it resembles "joint 3: ' in said
    )
    assert not any(sentence in page for sentence in scaled.findings[0].effect.advice)


@pytest.mark.slow
def test_a_doubtful_scatter_is_unattributed(scattered):
    """The entry has no name, most resembles a jitter, and depends on all joints; the report states no cause."""
    (entry,) = scattered.to_mapping()["effects"]
    assert scattered.verdict == entry["name"] == "unattributed"
    assert [like["name"] for like in entry["most_like"]] == ["pose_jitter"]
    assert entry["depends_on"] == [f"q{i + 1}" for i in range(scattered.dataset.robot.n_joints)]
    page = render_report(scattered)
    assert "do not show what causes it" in page and "come back to a pose only up to" not in page


def test_with_the_usual_settings_the_name_is_given(scaled):
    """With the usual settings the same data name the joint: the threshold decides, and nothing else differs."""
    usual = diagnose(scaled.dataset)
    (entry,) = usual.to_mapping()["effects"]
    assert (usual.verdict, entry["name"]) == ("effect", "joint_scale")
    np.testing.assert_allclose(
        usual.calibration_after.model.effects[0].coefficients,
        scaled.calibration_after.model.effects[0].coefficients,
        rtol=1e-9,
    )


def test_a_name_that_is_confounded_is_given_with_its_rivals():
    """Planes with known places show an error of the range, but hardly whether it is proportional to the range: either effect is likely, and both are
    stated.
    """
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


def test_what_a_rival_explains_beside_an_effect_does_not_speak_against_it():
    """What a rival explains with the effect in the model as well does not count against the effect; a rival without such evidence keeps all of it."""
    rival, other = scored(JointScale(3), evidence=40.0), scored(JointScale(4), evidence=12.0)
    beside = [scored(JointScale(3), evidence=37.0), scored(JointBacklash(3, "approach"), evidence=9.0)]
    assert _in_place_alone(rival, beside).evidence == 3.0
    assert _in_place_alone(other, beside).evidence == 12.0
