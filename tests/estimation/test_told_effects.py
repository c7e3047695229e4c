"""A calibration that is told the effects: errors of the arm without them must not decide how near to the data sheet it stays."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.effects.command_line import parse_effects
from scalar.estimation.calibrate import calibrate
from scalar.estimation.data_sheet_priors import data_sheet_priors
from scalar.estimation.joint_fit import unobservable_coefficients
from scalar.estimation.prepare import prepare
from scalar.estimation.residuals import Residuals
from scalar.evaluate import evaluate
from tests.effects.injected import Flaws, make_cell

MIDDLE = 0.275  # [m], of the ranges that the scanner of these workcells measures
TOLD = "range_distortion,range_offset,joint_harmonic:2:1,joint_harmonic:3:2"


def gears(at):
    """Return errors of joints 2 and 3 ``(N, n)`` [rad], twenty times what the noise hides."""
    errors = np.zeros_like(at.q)
    errors[:, 1] = 2e-3 * np.sin(at.q[:, 1] + 0.4)
    errors[:, 2] = 2e-3 * np.sin(2 * at.q[:, 2] + 1.1)
    return errors


def curved(r):
    """Return ranges [m] as a scanner has them whose zero is off by 0.4 mm and whose range is curved."""
    return r + 4e-4 + 0.01 * (r - MIDDLE) ** 2


@pytest.mark.parametrize("seed", [41, 42])
def test_a_calibration_that_is_told_strong_effects_is_as_good_as_one_without_them_in_a_perfect_arm(seed):
    """Told all that is wrong, the calibration errs by at most three times the noise's error; the rigid model errs by tenths of a millimetre."""
    perfect, cell = make_cell(seed=seed), make_cell(Flaws(joints=gears, measured=curved), seed=seed)
    effects = parse_effects(TOLD, cell.dataset)
    table, _ = cell.truth_poses(500, np.random.default_rng(seed))
    without_flaws, _ = perfect.truth_poses(500, np.random.default_rng(seed))
    told, rigid = (calibrate(cell.dataset, effects=some) for some in (effects, ()))
    errors = [evaluate(c, table).aligned.position.mean() for c in (told, rigid)]
    floor = evaluate(calibrate(perfect.dataset), without_flaws).aligned.position.mean()
    assert errors[0] < 3 * floor and errors[1] > 2e-4
    held = calibrate(cell.dataset, fixed_effects=told.model.effects)
    assert evaluate(held, table).aligned.position.mean() < 3 * floor


def test_priors_of_the_arm_make_no_gain_of_the_range_observable():
    """A gain of the range is a scale of the arm: no measurement shows it, even if priors state every length to a micrometre."""
    dataset = make_cell(Flaws(joints=gears), seed=43).dataset
    prepared = prepare(dataset)
    (gain,) = parse_effects("range_scale", dataset)
    model = replace(prepared.initial.model, effects=(gain,), priors=())
    free = np.r_[prepared.free, True]
    residuals = Residuals.of(dataset, model).reweighted(model)
    tight = tuple(replace(prior, std=1e-6) for prior in data_sheet_priors(model, free))
    with_priors = replace(model, priors=tight)
    assert len(tight) > 6
    for each in (model, with_priors):
        assert unobservable_coefficients(residuals, each, free)[-1]
