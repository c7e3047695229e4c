"""Where the arm gives way or structure is unexplained, and no load is recorded, the report advises to record it; it diagnoses none."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_scale import JointScale
from scalar.report import render_report
from scalar.report.load_advice import load_advice
from tests.effects.injected import gravity_torques
from tests.random_scene import make_scene

UNEXPLAINED = "If the flange carried a part, a tool or a cable"


def advised(effect: Any, *, verdict: str = "effect", doubtful: bool = False, **columns: float) -> str:
    """Return the advice for a diagnosis with one finding, or none, in data with further columns."""
    dataset = make_scene(kind="tracker", seed=1, poses_per_plane=4).dataset
    dataset = replace(dataset, poses=dataset.poses.assign(**columns))
    findings = [] if effect is None else [SimpleNamespace(effect=effect, doubtful=doubtful)]
    diagnosis: Any = SimpleNamespace(dataset=dataset, findings=findings, verdict=verdict)
    return " ".join(load_advice(diagnosis))


def test_a_load_is_asked_for_where_the_arm_gives_way() -> None:
    """A compliance under the arm's weight asks for the columns of the load; another effect does not, and nothing is said where they are recorded."""
    weight = JointCompliance(((2, 2),))
    text = advised(weight)
    assert "column payload [kg]" in text and "payload_x, payload_y, payload_z" in text and "tau1" in text
    assert UNEXPLAINED not in text
    assert not advised(JointScale(2)) and not advised(None, verdict="no_effect")
    assert not advised(weight, payload=2.0) and not advised(weight, tau1=1.0)


@pytest.mark.parametrize("recorded", [False, True])
def test_a_hidden_load_is_one_thing_to_record_beside_structure_without_a_name(recorded: bool) -> None:
    """With and without a compliance, the columns are named once, and no cause is."""
    columns = {"payload": 0.0} if recorded else {}
    for effect, doubtful, verdict in (
        (None, False, "unattributed"),
        (JointCompliance(((2, 2),)), False, "unattributed"),
        (JointScale(2), True, "unattributed"),
    ):
        text = advised(effect, doubtful=doubtful, verdict=verdict, **columns)
        assert (UNEXPLAINED in text) != recorded
        assert text.count("column payload [kg]") == (not recorded)
        assert recorded or "these data do not tell whether there was one" in text


@pytest.mark.slow
def test_the_report_on_a_load_that_nobody_recorded_advises_to_record_it() -> None:
    """Half of the poses of a compliant arm carry a load: the verdict stays that of unmodelled structure, and the report names the column."""
    scene = make_scene("ur10e", "tracker", poses_per_plane=50, seed=4, noise=3e-5)
    q, N = scene.dataset.q, scene.dataset.n_poses
    loaded = np.random.default_rng(1).random(N) < 0.5
    arm = gravity_torques(scene.truth, q, np.array([5.0, 10.0, 6.0, 2.0, 2.0, 1.0]), np.zeros((6, 3)))
    load = gravity_torques(scene.truth, q, np.eye(6)[5], np.array([*[[0.0] * 3] * 5, [0.0, 0.0, 0.1]]))
    error = 6e-6 * (arm + 10.0 * loaded[:, None] * load) * np.isin(np.arange(6), (1, 2))
    columns = {f"q{j + 1}": q[:, j] - error[:, j] for j in range(6)}
    found = diagnose(replace(scene.dataset, poses=scene.dataset.poses.assign(**columns)))
    assert found.verdict == "unattributed"
    section = render_report(found).split("<h2>What to do next</h2>")[1].split("<h2>")[0]
    assert "Record what the flange carried" in section and UNEXPLAINED in section
