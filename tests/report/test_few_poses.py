"""Where poses are too few to find an effect, the diagnosis says so, and how many more are needed; these do find it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.diagnosis_words import describe_diagnosis
from scalar.diagnosis import diagnose
from scalar.diagnosis.result import Diagnosis
from scalar.report import render_report, words
from scalar.report.few_poses import few_poses
from tests.random_scene import make_scene


def sagging(poses_per_plane: int) -> Diagnosis:
    """Return the diagnosis of an arm whose joint 2 gives way under a mass at the sensor: by 1 mrad where it is a metre from the axis."""
    scene = make_scene("vs060", poses_per_plane=poses_per_plane, points_per_scan=40, noise=1e-4, seed=1)
    q_true = scene.dataset.q
    read = q_true.copy()
    at = scene.truth.sensor(q_true)[:, :3, 3]
    reach = np.cos(q_true[:, 0]) * at[:, 0] + np.sin(q_true[:, 0]) * at[:, 1]
    read[:, 1] -= 1e-3 * reach
    dataset = replace(scene.dataset, poses=scene.dataset.poses.assign(q2=read[:, 1]))
    return diagnose(dataset, outer_folds=0)


@pytest.fixture(scope="module")
def few() -> Diagnosis:
    """Return that of 36 scans."""
    return sagging(12)


def test_too_few_poses_are_said_with_how_many_more(few: Diagnosis) -> None:
    """In 36 scans, two of one pose, nothing certain is found: terminal and report say that they are too few, and the report leads to plan."""
    assert not few.findings
    (sentence,) = few_poses(few)
    more = int(re.search(r"Measure at least (\d+) more", sentence)[1])
    assert (
        20 <= more <= 60
        and f"--poses {more}" in sentence
        and "35 different ones give 70 equations" in sentence
    )
    assert sentence in describe_diagnosis(few)
    lead = re.findall(r'<p class="lead">(.*?)</p>', render_report(few))
    assert "Too few poses" in lead[1]


@pytest.mark.slow
def test_with_as_many_more_the_effect_is_named(few: Diagnosis) -> None:
    """With the poses that were asked for the compliance is named, and the report explains its confidence and no longer speaks of few poses."""
    more = int(re.search(r"Measure at least (\d+) more", few_poses(few)[0])[1])
    found = sagging(12 + -(-more // 3))
    assert [finding.effect.name for finding in found.findings] == ["joint_compliance"]
    assert few_poses(found) == []
    page, said = render_report(found), describe_diagnosis(found)
    assert words.CONFIDENCE in page and words.CONFIDENCE in said
    assert re.search(r"joint.*compliance.*; confidence (above )?\d+ %", said)
