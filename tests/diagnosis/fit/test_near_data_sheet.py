"""The final fits of a diagnosis keep what the poses hardly determine near the data sheet, and nothing else."""

import numpy as np
import pytest

from scalar import calibrate, diagnose
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.near_data_sheet import near_data_sheet
from scalar.diagnosis.shipping.nested_models import NestedModels
from scalar.effects import registry
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, make_cell
from tests.estimation.test_data_sheet_priors import elsewhere, workcell
from tests.estimation.test_initial_estimate import pointing_up


def fitted(count: int, gear: float):
    """Return a dataset of some poses with worn gears, and its state without effects and without priors."""
    dataset, _ = workcell(7, elsewhere(np.random.default_rng(7), count), gear=gear)
    model, prepared = geometry_fit(dataset, effects_follow=True)
    return dataset, refit(dataset, model, prepared.free, ())


def test_few_poses_with_gears_end_where_a_calibration_ends():
    """The geometry that a diagnosis ships without effects is that of a calibration of the same data."""
    dataset, state = fitted(18, 1e-3)
    assert not state.model.priors
    found = near_data_sheet(state).model
    expected = calibrate(dataset).model
    assert found.priors and len(found.priors) == len(expected.priors)
    apart = found.robot.geometry - expected.robot.geometry
    changed = expected.robot.geometry - dataset.robot.geometry
    assert np.linalg.norm(apart) < 0.1 * np.linalg.norm(changed)


def test_what_the_poses_determine_stays_as_it_is():
    """With many poses and no misfit, the priors change the geometry by at most a twentieth of its distance from the data sheet."""
    dataset, state = fitted(200, 0.0)
    apart = near_data_sheet(state).model.robot.geometry - state.model.robot.geometry
    changed = state.model.robot.geometry - dataset.robot.geometry
    assert np.linalg.norm(apart) < 0.05 * np.linalg.norm(changed)


def test_variance_components_are_identified_without_priors():
    """If each scan has its own error, the priors have much weight; the errors that they would leave in the geometry are not named a jitter."""
    cell = make_cell(Flaws(bias=1.3e-4), seed=4, poses_per_plane=20, points_per_scan=30, noise=5e-5)
    diagnosis = diagnose(cell.dataset)
    assert diagnosis.calibration_before.model.priors
    (effect,) = diagnosis.to_mapping()["effects"]
    assert effect["name"] == "scan_bias"
    assert effect["coefficients"]["std_m"]["value"] == pytest.approx(1.3e-4, rel=0.3)


@pytest.mark.parametrize("seed", [1, 3, 6])
def test_an_effect_does_not_move_a_tool_along_a_direction_that_the_poses_do_not_show(seed):
    """The tool points up at all poses, and the effect is not what is wrong with the arm: it had moved the tool by 22 to 50 mm."""
    dataset = pointing_up(seed, gear=1e-3)
    effects = registry.known()["joint_scale"].candidates(dataset)
    found = calibrate(dataset, effects=effects)
    assert found.model.T_flange_sensor[2, 3] == pytest.approx(dataset.sensor.T_flange_sensor[2, 3], abs=1e-3)
    assert found.std["sensor_z"] > 0.04  # m: and yet it may lie as far off as any stated place may


def test_the_expected_error_counts_how_wrong_a_held_place_may_be():
    """The place of a tool that points up at all poses is held during the fit; at poses that turn it, errors of centimetres are expected."""
    dataset = pointing_up(1, gear=1e-3)
    model, prepared = geometry_fit(dataset)
    effects = registry.known()["joint_scale"].candidates(dataset)
    held = near_data_sheet(refit(dataset, model, prepared.free, effects))
    (prior,) = [prior for prior in held.model.priors if prior.name == "sensor_z"]
    assert prior.held * prior.std < 2e-3
    assert NestedModels(held).std(tuple(range(len(effects)))) > 1e-2


def test_priors_that_are_made_again_keep_the_initial_place_of_the_tool():
    """The final fits make their priors anew; had these been centred where the last fit had ended, each fit would allow another step."""
    dataset = pointing_up(3, gear=1e-3)
    model, prepared = geometry_fit(dataset)
    first = {prior.name: prior.mean for prior in model.priors}
    moved = model.with_vector(model.vector + 0.02 * (np.array(model.names) == "sensor_z"))
    state = refit(dataset, moved, prepared.free, ())
    again = {prior.name: prior.mean for prior in near_data_sheet(state).model.priors}
    assert again["sensor_z"] == first["sensor_z"]
