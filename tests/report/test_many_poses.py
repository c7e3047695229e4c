"""A report of very many poses: it is drawn, opens, and stays small."""

from __future__ import annotations

import re

import pytest

from scalar.diagnosis import Diagnosis
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.held_out.hold_out import held_out_errors
from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.naming.grounds import EFFECT, FinalResiduals, Grounds
from scalar.diagnosis.shipping.shipped_fit import shipped_fit
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.conclude import conclude
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.gross_errors import clean
from scalar.estimation.joint_fit import fit_from
from scalar.report import render_report
from tests.random_scene import make_scene

GROUNDS = Grounds(EFFECT, 50.0, 40.0, 0.5, 1, False, False, FinalResiduals(3_000, 1.0, 1.0, False, True))


@pytest.mark.slow
@pytest.mark.parametrize("poses", [3_000, 12_000])
def test_a_report_of_many_tracked_poses_stays_below_three_megabytes(poses: int) -> None:
    """Thousands of tracked poses and an effect give a page of less than 3 MB, whose captions say what is not
    drawn. The diagnosis is put together from its parts: the search would take minutes."""
    dataset = make_scene(kind="tracker", seed=1, poses_per_plane=poses // 3).dataset
    cleaned = clean(dataset)
    model, prepared = geometry_fit(cleaned.dataset)
    before = refit(cleaned.dataset, model, prepared.free, ())
    after = refit(
        cleaned.dataset, before.model, prepared.free, (JointHarmonic(2, (3,)), JointHarmonic(3, (4,)))
    )
    calibrations = [
        conclude(cleaned.dataset, prepared, *fit_from(cleaned.dataset, state.model, state.free))
        for state in (before, after)
    ]
    errors = [held_out_errors(state) for state in (before, after)]
    effects = calibrations[1].model.effects
    page = render_report(
        Diagnosis(
            dataset=dataset,
            cleaned=cleaned,
            before=before,
            after=after,
            held_out_before=errors[0],
            calibration_before=calibrations[0],
            calibration_found=calibrations[1],
            calibration_after=calibrations[1],
            shipped=shipped_fit(before, after, None),
            findings=tuple(
                Finding(effect, 1e-9, *errors, (), 0.9, std, GROUNDS)
                for effect, std in zip(effects, calibrations[1].effect_std, strict=True)
            ),
            noise=(),
            noise_grounds=None,
            depends_on=(),
            unobservable=(),
            ranking=(),
        )
    )
    assert f"{poses} poses" in page
    assert len(page.encode()) < 3e6
    drawn = {int(n): int(count) for n, count in re.findall(r"(\d+) of (\d+) values are drawn", page)}
    assert all(count > n for n, count in drawn.items())
    assert bool(drawn) == (poses > 3_000)
