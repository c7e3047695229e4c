"""The page of a calibration: the errors of the arm by its data sheet and as calibrated, and every parameter."""

from __future__ import annotations

from typing import Any

from scalar.data.dataset import Dataset
from scalar.diagnosis.accuracy.discrepancy_of_fit import discrepancy_of_calibration
from scalar.diagnosis.fit.fitted_state import state_of
from scalar.estimation.misfit import lacks_something, may_lack_something
from scalar.estimation.result import Calibration
from scalar.estimation.usual_noise import exceeds_usual_noise
from scalar.report.calibration_residual import far_poses_in_words, residual_in_words
from scalar.report.diagnosed_workspace import repeated_in_words
from scalar.report.parameter_table import convention_in_words, gauge_rows, parameter_tables
from scalar.report.unseen_directions_words import unseen_directions_sentences
from scalar.report.unstated_noise import unstated_noise_in_words
from scalar.report.words import capital
from scalar.report.workspace_map import workspace_section
from scalar.sensors import kind_of

FILE = "calibration.json"


def calibration_page(calibration: Calibration, dataset: Dataset) -> dict[str, Any]:
    """Return everything that the template ``calibration.html.jinja`` needs.

    Args:
        calibration: The calibration to report.
        dataset: The dataset from which it was estimated.
    """
    measured_poses = dataset.known_poses
    discrepancy = discrepancy_of_calibration(calibration, state_of(calibration, dataset))
    workspace = workspace_section(calibration, None, measured_poses, FILE, discrepancy)
    if workspace is not None:
        workspace["repeated"] = repeated_in_words(dataset, calibration.model)
    about = [f"robot {dataset.robot.name}, {dataset.robot.n_joints} joints", kind_of(dataset).words]
    return {
        "name": dataset.name,
        "about": " · ".join([*about, f"{calibration.summary['poses']} poses"]),
        "opening": [
            _what_it_is(workspace, unstated_noise_in_words(calibration) != ""),
            _what_to_do(calibration),
            *unseen_directions_sentences(calibration),
        ],
        "setup": [
            *(suspicion["sentence"] for suspicion in calibration.summary.get("setup", [])),
            *far_poses_in_words(calibration, dataset),
        ],
        "workspace": workspace,
        "file": FILE,
        "convention": convention_in_words(dataset.robot),
        "parameters": parameter_tables(calibration, dataset.sensor.T_flange_sensor),
        "gauge": gauge_rows(calibration),
        "planes": bool(dataset.planes),
    }


def _what_it_is(workspace: dict[str, Any] | None, untested: bool) -> str:
    """Return what the calibration errs by; ``untested`` says that nothing shows whether the residual is noise."""
    if workspace is None:
        return f"{FILE} is the calibration of arm, sensor and target; the fit does not tell how far its predictions are off."
    before, after = workspace["rows"][0]["mean"], workspace["rows"][-1]["mean"]
    rest = ", if the residual is noise." if untested else "."
    if workspace["excess"]:
        rest = f". What the residual has beyond the noise would alone make {workspace['excess']}."
    return (
        f"By the data sheet, the arm errs by {before['value']} on average over its workspace (95 % band {before['band']}); by {FILE}, it errs by "
        f"{after['value']} ({after['band']}){rest}"
    )


def _what_to_do(calibration: Calibration) -> str:
    misfit, what = calibration.summary.get("misfit"), residual_in_words(calibration.summary)
    if lacks_something(calibration.summary):
        return (
            f"Run 'scalar diagnose' before you rely on that: {what} is {misfit:.1f} times what the "
            "noise explains, so the model lacks something, and at other poses the arm may err by more than that band."
        )
    if may_lack_something(calibration.summary):
        return (
            f"Run 'scalar diagnose' to be sure: {what} is {misfit:.2f} times what the noise explains, "
            f"which noise alone makes with probability {calibration.summary['misfit_p_value']:.1g}, so the model may lack something."
        )
    if exceeds_usual_noise(calibration):
        return f"{capital(unstated_noise_in_words(calibration))} before you rely on that."
    if untested := unstated_noise_in_words(calibration):
        return f"{capital(untested)}. Do this, or run 'scalar diagnose', before you rely on it."
    return f"Use it: 'scalar correct {FILE} program.csv -o corrected.csv' corrects the joint angles of a program."
