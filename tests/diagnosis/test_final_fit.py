"""If an effect acts on single points, the shipped fit minimises the same rows by which the effects were selected."""

import numpy as np

from scalar.diagnosis.explained import _final_fit
from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.effects import Effect
from scalar.effects.joint_scale import JointScale
from scalar.effects.range_offset import RangeOffset
from scalar.effects.sensor_map import SensorMap
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, make_cell


def wavy_lens(r: np.ndarray) -> np.ndarray:
    """Return ranges with a wrong zero, and with waves that no effect of the catalogue describes."""
    return r + 4e-4 + 5e-5 * np.sin(2 * np.pi * r / 0.04)


def state_with(kinds: list[type[Effect]], flaws: Flaws) -> FittedState:
    """Return a workcell fitted with some effects."""
    dataset = make_cell(flaws, seed=81, poses_per_plane=30, points_per_scan=80, noise=3e-5).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    effects = [kind.parsed(dataset, ["2"] if kind is JointScale else [])[0] for kind in kinds]
    return refit(dataset, model, prepared.free, effects)


def test_errors_within_the_scans_do_not_bias_the_poses():
    """With a scanner whose waves are not in the model, the final fit leaves the zero of the range and the arm where the profile rows have them."""
    state = state_with([SensorMap, RangeOffset], Flaws(measured=wavy_lens))
    final, _ = _final_fit(state, None)
    lengths = state.model.robot.geometry - final.model.robot.geometry
    assert np.abs(lengths).max() < 1e-6
    assert np.abs(final.model.effects[1].coefficients - state.effects[1].coefficients).max() < 1e-6


def test_all_points_are_used_where_effects_act_on_whole_poses():
    """An effect of a joint is fitted to all points, as a calibration without effects is."""
    state = state_with([JointScale], Flaws())
    _, residuals = _final_fit(state, None)
    assert state.residuals.measurement.profiled and not residuals.measurement.profiled
