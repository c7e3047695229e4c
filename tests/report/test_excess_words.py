"""What the model of a diagnosis still lacks is counted in the errors that its report states, and said."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.cli.diagnosis_words import describe_diagnosis
from scalar.diagnosis.accuracy.excess_residual import excess_distance_after
from scalar.diagnosis.diagnose import diagnose
from scalar.diagnosis.result import Diagnosis
from scalar.diagnosis.shipping.shipped_fit import BY_COMPONENT
from scalar.estimation.calibrate import calibrate
from scalar.evaluate.workspace_errors import aligned_errors
from scalar.report.calibration_page import calibration_page
from scalar.report.excess_words import SCATTER_OF_WHAT, unexplained_excess
from scalar.report.fleet_row import row_of
from scalar.report.page import page
from scalar.units import MM
from tests.diagnosis.test_patterns_are_no_noise import loose_mount
from tests.diagnosis.unnamed_causes import unnamed
from tests.effects.injected import Flaws, PoseData, make_cell, on_joint
from tests.random_scene import make_scene


def upper_end(banded: dict[str, str]) -> float:
    """Return the upper end [mm] of a band of the report."""
    return float(banded["band"].split(" to ")[1].removesuffix(" mm"))


@pytest.fixture(scope="module")
def few() -> Diagnosis:
    """Return the diagnosis of sixty poses of an arm whose joint errs as no effect does: too few to find anything."""
    return diagnose(unnamed(1, poses_per_plane=20)[0].dataset, outer_folds=0)


@pytest.mark.parametrize(("scatter", "beyond"), [(1.5, True), (0.05, False)])
def test_a_scatter_that_no_instrument_has_is_not_called_noise(scatter: float, beyond: bool) -> None:
    """No noise is stated, and positions scatter by so many millimetres: beyond what trackers do, 'nothing is lacking' would contradict calibrate."""
    scene = make_scene("vs060", "tracker", poses_per_plane=25, noise=scatter * MM, seed=41).dataset
    answer = diagnose(replace(scene, sensor=replace(scene.sensor, noise=None)), outer_folds=0)
    told, text = page(answer)["opening"], describe_diagnosis(answer)
    assert answer.verdict == "no_effect"
    for said in (told[0], text):
        assert ("more than the noise of an instrument" in said) == beyond
        assert ("nothing that the model lacks" in said) != beyond and (
            "noise alone would leave" in said
        ) != beyond
    assert (SCATTER_OF_WHAT in told[1] and SCATTER_OF_WHAT in text) == beyond


@pytest.mark.slow
def test_an_excess_that_nothing_explains_is_said_and_counted(few: Diagnosis) -> None:
    """The residual is far beyond chance: the report does not say that nothing is lacking, and counts the excess in the error over the workspace."""
    summary = few.calibration_after.summary
    assert few.verdict == "no_effect" and summary["misfit"] > 1.15 and summary["misfit_p_value"] < 1e-3
    told = page(few)
    assert "because of something that these data do not name" in told["opening"][0]
    for text in (*told["opening"], describe_diagnosis(few)):
        assert "nothing that the model lacks" not in text
    at_unseen = float(told["workspace"]["excess"].removesuffix(" mm"))
    assert at_unseen > summary["misfit_shift_m"] * 1e3
    mean = told["workspace"]["rows"][-1]["mean"]
    assert upper_end(mean) > at_unseen
    stated = float(mean["value"].removesuffix(" mm"))
    assert row_of(few)["after_error_mm"] == pytest.approx(stated, rel=5e-3)  # stated with three digits


@pytest.mark.parametrize("seed", range(6))
def test_a_calibration_that_lacks_an_effect_states_what_it_errs_by_elsewhere(seed: int) -> None:
    """A gear that nobody declared: the mean error and that of 95 of 100 poses are stated within a factor of 2 or slightly more, and their bands hold.

    Counted as a distance alike at all poses, the latter was half of the true one.
    """
    rng = np.random.default_rng([451, seed])
    joint, size, phase = int(rng.integers(2, 6)), rng.uniform(3e-4, 1.2e-3), rng.uniform(0, 2 * np.pi)
    gear = on_joint(joint, lambda at: size * np.sin(at.q[:, joint - 1] + phase))
    cell = make_cell(Flaws(joints=gear), seed=700 + seed, poses_per_plane=25)
    calibration = calibrate(cell.dataset)
    rows = calibration_page(calibration, cell.dataset)["workspace"]["rows"]
    table, at = cell.truth_poses(2000, np.random.default_rng(9))
    errors = aligned_errors(calibration.predict(table), cell.sensor(at))
    sizes = np.linalg.norm(errors, axis=1) * 1e3
    for what, true in (("mean", sizes.mean()), ("most", np.quantile(sizes, 0.95))):
        stated = float(rows[-1][what]["value"].removesuffix(" mm"))
        assert true / 2 < stated < 2.5 * true
        assert true < float(rows[-1][what]["band"].split(" to ")[1].removesuffix(" mm"))


@pytest.mark.parametrize("poses", [6, 7, 8])
def test_few_poses_state_no_error_that_the_fit_without_a_region_has(poses: int) -> None:
    """With so few poses that a part of them does not determine the arm, no error from a fit to a part is stated: it would be many times too large."""
    cell = make_cell(
        Flaws(joints=on_joint(3, lambda at: 8e-4 * np.sin(at.q[:, 2]))),
        seed=31,
        poses_per_plane=poses,
        noise=3e-5,
    )
    calibration = calibrate(cell.dataset)
    row = calibration_page(calibration, cell.dataset)["workspace"]["rows"][-1]["mean"]
    table, at = cell.truth_poses(2000, np.random.default_rng(9))
    true = 1e3 * np.linalg.norm(aligned_errors(calibration.predict(table), cell.sensor(at)), axis=1).mean()
    assert true / 4 < float(row["value"].removesuffix(" mm")) < 4 * true


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2])
def test_a_pattern_without_a_name_is_counted_in_the_error(seed: int) -> None:
    """A loose mount moves the sensor by gravity, and is reported as no random error. The map states the arm's true error within a factor of 1.5,
    whether poses are fitted with equal weights or with those of the component that hides the excess."""
    truth = make_cell(seed=seed, poses_per_plane=3).scene.truth
    cell = make_cell(loose_mount(truth), seed=seed, poses_per_plane=34)
    found = diagnose(cell.dataset, outer_folds=0)
    low, high = cell.dataset.robot.limits.T
    q = np.random.default_rng(9).uniform(low, high, (3000, 6))
    order = np.random.default_rng(8).uniform(0, cell.dataset.n_poses - 1, len(q))
    errors = aligned_errors(
        found.calibration_after.predict(q, order=order), cell.sensor(PoseData(q, order, {}))
    )
    errs = float(np.mean(np.linalg.norm(errors, axis=1))) * 1e3
    stated = float(page(found)["workspace"]["rows"][-1]["mean"]["value"].removesuffix(" mm"))
    assert errs / 1.5 < stated < 1.5 * errs


@pytest.mark.slow
def test_a_random_error_that_is_not_confirmed_is_counted() -> None:
    """Poses that scatter are weighed by it; where the runs without a part of the poses do not confirm the name, the error over the workspace
    counts the scatter, which the weights hide from the fit."""
    cell = make_cell(Flaws(jitter=2e-4), seed=6, poses_per_plane=80)
    found = diagnose(cell.dataset, outer_folds=0)
    assert found.shipped.fit == BY_COMPONENT and found.reported_noise and excess_distance_after(found) == 0.0
    assert found.calibration_after.summary["misfit"] < 1.15
    doubted = replace(found, noise=())
    assert not doubted.reported_noise
    shift = excess_distance_after(doubted)
    assert 5e-5 < shift < 1e-3
    assert upper_end(page(doubted)["workspace"]["rows"][-1]["mean"]) > shift * 1e3


def test_a_random_error_that_is_named_is_not_counted() -> None:
    """Poses that scatter at random, and are reported so, are no error of the model: the report states their scatter on its own."""
    summary = {"misfit": 3.0, "misfit_p_value": 0.0, "misfit_shift_m": 1e-4}
    named: Any = SimpleNamespace(
        reported_noise=(object(),),
        noise_without_a_name=False,
        shipped=SimpleNamespace(without_effects=False, fit="equal_weights"),
        calibration_after=SimpleNamespace(summary=summary),
    )
    assert excess_distance_after(named) == 0.0


def test_what_a_named_effect_leaves_is_said() -> None:
    """Backlash whose side was not recorded scatters like noise beside a compliance that has a name: the report says that more is lacking."""
    named: Any = SimpleNamespace(
        verdict="effect",
        findings=(object(),),
        reported_noise=(),
        shipped=SimpleNamespace(without_effects=False),
        calibration_after=SimpleNamespace(summary={"misfit": 2.29, "misfit_p_value": 0.0}),
        after=SimpleNamespace(residuals=SimpleNamespace(measurement=SimpleNamespace(scans=False))),
    )
    (sentence,) = unexplained_excess(named)
    assert "still 2.3 times what the noise explains" in sentence and "larger than stated" in sentence
    for change in ({"verdict": "unattributed"}, {"findings": ()}, {"reported_noise": (object(),)}):
        assert not unexplained_excess(SimpleNamespace(**{**vars(named), **change}))  # type: ignore[arg-type]
    named.calibration_after = SimpleNamespace(summary={"misfit": 1.05, "misfit_p_value": 0.1})
    assert not unexplained_excess(named)
