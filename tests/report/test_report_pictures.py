"""The pictures of a report show what was injected, with the numbers of the diagnosis; the terminal's summary agrees with the report."""

from __future__ import annotations

import re

import numpy as np
import pytest

from scalar.cli.diagnosis_words import describe_diagnosis
from scalar.diagnosis import Diagnosis
from scalar.diagnosis.fit.partial_residuals import FittedView
from scalar.diagnosis.fit.scan_residuals import signed_residual
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.picture import Map, Profile
from scalar.report import render_report
from scalar.units import MM
from tests.report.periodic_joint import AMPLITUDE, JOINT, OF_RESIDUAL, ORDER, injected


def view_of(diagnosis: Diagnosis) -> FittedView:
    """Return what the pictures of effects are drawn from."""
    after = diagnosis.calibration_after
    return FittedView.of(diagnosis.after, after.free, after.covariance)


def pictures_of(diagnosis: Diagnosis) -> list[Profile | Map]:
    """Return the pictures of the first effect."""
    return diagnosis.after.effects[0].pictures(view_of(diagnosis))


def test_the_injected_effect_is_named(periodic_diagnosis: Diagnosis) -> None:
    """The injected harmonic, which the other tests need, is found with its joint and order."""
    assert [f.effect.target for f in periodic_diagnosis.findings if isinstance(f.effect, JointHarmonic)] == [
        {"joint": JOINT, "order": ORDER}
    ]


def test_a_dot_tells_its_pose_and_value(null_diagnosis: Diagnosis) -> None:
    """In the picture of the residual every pose has a dot, whose text states the pose, its place in the order and its residual [mm]."""
    shown = re.findall(
        r"<title>pose (\d+) at order ([\d.]+): (\S+) mm</title>", render_report(null_diagnosis)
    )
    state = null_diagnosis.after
    poses, residual = state.dataset.poses["pose"].to_numpy(), signed_residual(state) / MM
    expected = {
        int(p): (float(o), r) for p, o, r in zip(poses, state.residuals.poses.order, residual, strict=True)
    }
    pictures = len(re.findall(OF_RESIDUAL, render_report(null_diagnosis)))
    assert {int(p) for p, _, _ in shown} == set(expected)
    if pictures == 1:
        assert len(shown) == len(expected)
        for pose, order, value in shown:
            assert float(order) == pytest.approx(expected[int(pose)][0])
            assert float(value.replace("−", "-")) == pytest.approx(expected[int(pose)][1], rel=6e-3)


def test_bars_of_the_errors_have_one_scale(periodic_diagnosis: Diagnosis, periodic_page: str) -> None:
    """The lengths of the four bars of errors are proportional to their numbers, to a pixel or so."""
    residual = periodic_diagnosis.to_mapping()["residual"]
    keys = [(w, k) for k in ("held_out_rms_mm", "held_out_max_mm") for w in ("before", "after")]
    values = np.array([residual[w][k] for w, k in keys])
    widths = np.array(
        [float(w) for w in re.findall(r'<i class="(?:before|after)" style="width:([\d.]+)%"', periodic_page)]
    )
    np.testing.assert_allclose(widths / widths.max(), values / values.max(), atol=0.002)


def test_curve_is_the_injected_one(periodic_diagnosis: Diagnosis) -> None:
    """The fitted curve of the picture agrees with the injected error of the joint within five of its own standard errors."""
    profile = pictures_of(periodic_diagnosis)[0]
    assert isinstance(profile, Profile) and profile.curve is not None
    x, curve, std = profile.curve
    assert np.all(np.abs(curve - injected(x)) < 5 * std + 1e-6)
    assert np.ptp(curve) > 1.5 * AMPLITUDE


def test_dots_scatter_about_the_injected_curve_by_their_standard_errors(
    periodic_diagnosis: Diagnosis,
) -> None:
    """The difference of each pose's dot and the injected error there has the standard error that the picture states for it."""
    profile = pictures_of(periodic_diagnosis)[0]
    assert isinstance(profile, Profile)
    z = (profile.y - injected(periodic_diagnosis.after.residuals.poses.q[:, JOINT - 1])) / profile.std
    np.testing.assert_allclose(profile.y - profile.rest, profile.fitted, rtol=0, atol=1e-15)
    assert 0.7 < 1.4826 * np.median(np.abs(z)) < 1.4


def test_added_variable_plot_has_slope_one(periodic_diagnosis: Diagnosis) -> None:
    """Given all other parameters, measured against predicted shift has a slope near one, since the residual is orthogonal."""
    profile = view_of(periodic_diagnosis).added_variable(periodic_diagnosis.after.effects[0])
    slope = np.sum(profile.x * profile.y / profile.std**2) / np.sum(profile.x**2 / profile.std**2)
    assert slope == pytest.approx(1.0, abs=0.1)


def test_the_share_left_is_that_of_a_projection(periodic_diagnosis: Diagnosis) -> None:
    """The share of an effect's signal that other parameters do not absorb, computed from the Gram matrix, is that left by a least-squares fit."""
    state = periodic_diagnosis.after
    jacobian = state.linearised()[1]
    effect = state.effects[0]
    start = int(state.free[: state.model.blocks["effects"].start].sum())
    mine = np.zeros(jacobian.shape[1], dtype=bool)
    mine[start : start + len(effect.coefficients)] = True
    signal = jacobian[:, mine] @ effect.coefficients
    scale = np.linalg.norm(jacobian, axis=0)
    others = (jacobian / scale)[:, ~mine]
    left = signal - others @ np.linalg.lstsq(others, signal, rcond=None)[0]
    expected = np.linalg.norm(left) / np.linalg.norm(signal)
    assert view_of(periodic_diagnosis).share_left(periodic_diagnosis.after.effects[0]) == pytest.approx(
        expected, rel=1e-4
    )


def test_many_coefficients_are_summed_up_in_the_terminal(
    periodic_diagnosis: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If an effect has more coefficients than a line can list, the line states how large the effect is in all, as the report does."""
    monkeypatch.setattr("scalar.cli.diagnosis_words._COEFFICIENTS_SHOWN", 1)
    line = next(
        line for line in describe_diagnosis(periodic_diagnosis).splitlines() if "more coefficients" in line
    )
    assert re.search(r", up to 0\.\d+ deg: ", line)


def test_terminal_summary_is_short_and_plain(
    periodic_diagnosis: Diagnosis, null_diagnosis: Diagnosis
) -> None:
    """The summary has about ten lines and consists of ASCII characters, which any terminal can show."""
    for diagnosis in (periodic_diagnosis, null_diagnosis):
        text = describe_diagnosis(diagnosis)
        assert len(text.splitlines()) <= 14
        assert text.isascii()
