"""A tool on the last joint's axis, beside it, or drawn elsewhere than it is: nothing is found that is not there."""

from dataclasses import replace

import numpy as np
import pytest

from scalar import calibrate, diagnose
from tests import kinematics
from tests.random_scene import make_scene

LENGTH = 0.085  # m, of the tool along the axis
SIDEWAYS = np.array([12.0, -7.0]) / np.hypot(12.0, 7.0)
DISTANCES = [0.0, 0.3e-3, 1e-3, 3e-3, 13.9e-3]  # m off the axis
ERRORS = 2e-3  # m and rad, of the data sheet


def scene(robot, kind, off, drawn_on_axis, seed):
    """Return a workcell whose tool is ``off`` [m] from the last axis and drawn on it, or 1.4 mm from the truth."""
    true, drawn = np.eye(4), np.eye(4)
    true[:3, 3] = *(off * SIDEWAYS), LENGTH
    drawn[:3, 3] = (0.0, 0.0, LENGTH) if drawn_on_axis else true[:3, 3] + [1e-3, 1e-3, -1e-3]
    if kind == "line-laser":  # a scanner looks somewhere
        true[:3, :3] = drawn[:3, :3] = kinematics.rotate_about(np.array([0.3, -0.2, 0.5]), 0.5)
    made = make_scene(
        robot,
        kind,
        seed=seed,
        poses_per_plane=34,
        noise=2e-5 if kind == "tracker" else 1e-4,
        length_error=ERRORS,
        angle_error=ERRORS,
        T_flange_sensor=true,
    )
    sensor = replace(made.dataset.sensor, T_flange_sensor=drawn)
    return replace(made, dataset=replace(made.dataset, sensor=sensor))


@pytest.mark.parametrize(
    ("robot", "off", "drawn_on_axis"),
    [*(("vs060", off, True) for off in DISTANCES), *(("ur10e", off, False) for off in DISTANCES)],
)
def test_a_tracked_tool_near_the_axis_gives_no_finding(robot, off, drawn_on_axis):
    """Wherever the tool is and is declared to be, nothing is named for an arm without an effect."""
    diagnosis = diagnose(scene(robot, "tracker", off, drawn_on_axis, seed=11).dataset)
    assert (diagnosis.verdict, diagnosis.findings) == ("no_effect", ())


@pytest.mark.parametrize("off", [0.0, 13.9e-3])
def test_a_scanner_near_the_axis_gives_no_finding(off):
    """The same holds for scans, which show the last axis by their direction."""
    diagnosis = diagnose(scene("vs060", "line-laser", off, True, seed=12).dataset)
    assert (diagnosis.verdict, diagnosis.findings) == ("no_effect", ())


@pytest.mark.parametrize("off", DISTANCES[::2])
def test_predictions_are_as_right_as_they_say(off):
    """On the axis or off it, positions and parameters lie within their standard errors of the truth."""
    made = scene("vs060", "tracker", off, True, seed=13)
    calibration = calibrate(made.dataset)
    q = made.truth.poses(200, np.random.default_rng(0)).filter(like="q").to_numpy()
    predicted, true = calibration.predict(q)[:, :3, 3], made.truth.sensor(q)[:, :3, 3]
    error = np.linalg.norm(predicted - true, axis=1)
    position_std, _ = calibration.predict_std(q)
    assert np.all(error < 4.0 * position_std)
    truth, std = made.truth.parameters(), calibration.std
    off_by = [
        (calibration.parameters()[name]["value"] - truth[name]) / std[name] for name in std if name in truth
    ]
    assert np.max(np.abs(off_by)) < 4.0


def test_an_axis_rests_on_the_data_sheet_only_where_the_tool_does_not_show_it():
    """With a tool 14 mm off the axis no direction rests on the data sheet, and with one on the axis that of the axis does."""
    beside = calibrate(scene("vs060", "tracker", 13.9e-3, True, seed=14).dataset)
    upon = calibrate(scene("vs060", "tracker", 0.0, True, seed=14).dataset)
    assert not beside.summary["kept_near_data_sheet"]
    assert {"alpha_6", "theta_5"} <= set(upon.summary["kept_near_data_sheet"])
    assert upon.std["alpha_6"] > 5 * beside.std["alpha_6"]
    assert {"a_6", "d_5"}.isdisjoint(beside.fixed) and {"a_6", "d_5"}.isdisjoint(upon.fixed)
