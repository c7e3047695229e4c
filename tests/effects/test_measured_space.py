"""An instrument that distorts the space that it measures: its error is described exactly, and moves no prediction."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.effects.flexible.measured_space import UnattributedSpace
from scalar.effects.flexible.proposals import errors_of_instrument
from scalar.effects.flexible.unattributed import Unattributed
from scalar.estimation.calibrate import calibrate
from scalar.estimation.displacement import kinematics_at
from scalar.estimation.residuals import Residuals
from tests.effects.everything import with_random_coefficients
from tests.effects.test_columns import compare, model_with
from tests.random_scene import make_scene
from tests.turning import turning

SHAPES = ("strain", "quadratic", "azimuth1", "azimuth2", "elevation1", "elevation2")


def tracked(**settings):
    """Return what a tracker measures of an arm."""
    return make_scene(kind="tracker", seed=4, poses_per_plane=15, **settings).dataset


@pytest.mark.parametrize(("kind", "count"), [("tracker", len(SHAPES)), ("line-laser", 0), ("probe", 0)])
def test_only_instruments_that_stand_apart_distort_space(kind, count):
    """No term is tried for a sensor on the flange."""
    found = errors_of_instrument(make_scene(kind=kind, seed=2, poses_per_plane=6).dataset)
    assert [effect.key.removeprefix("unattributed_measured_space_") for effect in found] == list(
        SHAPES[:count]
    )


@pytest.mark.parametrize("which", range(len(SHAPES)))
def test_columns_are_derivatives(which):
    """The columns agree with central differences, beside an arm that is away from its optimum."""
    dataset = tracked()
    effect = with_random_coefficients(errors_of_instrument(dataset)[which], np.random.default_rng(3))
    compare(*model_with(dataset, (effect,), 9))


@pytest.mark.parametrize("which", range(len(SHAPES)))
def test_the_term_takes_the_distortion_away(which):
    """Positions that are moved by D c at the true position lie where the model expects them again, but for the distortion of the distortion."""
    dataset = tracked(noise=1e-6)
    effect = with_random_coefficients(errors_of_instrument(dataset)[which], np.random.default_rng(5))
    model = calibrate(dataset).model
    wrong = replace(dataset, points=dataset.points + effect.distortion(dataset.points) @ effect.coefficients)
    left = Residuals.of(wrong, model).rms(model)
    corrected = replace(model, effects=(effect,)).rebased()
    assert Residuals.of(wrong, corrected).rms(corrected) < 0.02 * left


@pytest.mark.parametrize("which", range(len(SHAPES)))
def test_no_prediction_depends_on_it(which):
    """What is predicted, and so what a program is corrected by, is that of the same model without the error of the instrument."""
    dataset = tracked()
    effect = with_random_coefficients(errors_of_instrument(dataset)[which], np.random.default_rng(6))
    model = calibrate(dataset).model
    with_it = replace(model, effects=(effect,)).rebased()
    with_it, without = (kinematics_at(m, dataset.known_poses).T_base_sensor for m in (with_it, model))
    assert np.array_equal(with_it, without)
    assert not effect.acts_on_arm and not effect.stays_with_arm


def test_a_strain_neither_turns_nor_grows():
    """Its gradient is symmetric and has no trace: the frame of the instrument and the size of the arm take up the rest."""
    effect, y = (
        UnattributedSpace("strain", centre=(1.0, 2.0, 0.5)),
        np.random.default_rng(1).normal(size=(4, 3)),
    )
    step = np.array([effect.distortion(y + h) - effect.distortion(y) for h in np.eye(3)])
    gradient = step.transpose(1, 3, 2, 0)  # (P, k, 3, 3)
    np.testing.assert_allclose(gradient, gradient.transpose(0, 1, 3, 2), atol=1e-12)
    np.testing.assert_allclose(np.trace(gradient, axis1=2, axis2=3), 0.0, atol=1e-12)


@pytest.mark.parametrize("order", [1, 2])
def test_an_error_of_an_angle_keeps_the_distance(order):
    """An error of the azimuth turns a point about z, one of the elevation about a level axis, by the angle that the wave has there."""
    y = np.random.default_rng(2).normal((4.0, 0.0, 0.0), size=(5, 3))
    for shape in ("azimuth", "elevation"):
        moved = UnattributedSpace(shape, order).distortion(y)
        np.testing.assert_allclose(np.einsum("pi,pik->pk", y, moved), 0.0, atol=1e-12)
        radius = np.hypot(y[:, 0], y[:, 1]) if shape == "azimuth" else np.linalg.norm(y, axis=1)
        np.testing.assert_allclose(np.sum(moved**2, axis=(1, 2)), radius**2)


@pytest.mark.parametrize("which", range(len(SHAPES)))
def test_a_stored_term_is_the_same(which):
    """Shape, order, centre and extent come back from a file."""
    effect = errors_of_instrument(tracked())[which]
    again = Unattributed.from_mapping(effect.to_mapping())
    assert (again.key, again.centre, again.half) == (effect.key, effect.centre, effect.half)


def test_words_send_to_the_instrument():
    """Description, advice and the sentence on the controller say that the arm is not at fault, and state the largest stretch."""
    effect = UnattributedSpace("strain").with_coefficients([3e-4, 0.0, 0.0, 0.0, 0.0])
    assert (
        "stretched by up to 0.3 mm per m" in effect.described_as
        and "not an error of the arm" in effect.described_as
    )
    assert (
        "instrument" in effect.clause
        and "instrument" in effect.advice[0]
        and "instrument" in effect.in_controller
    )
    assert effect.not_transferable(tracked())


def test_no_poses_have_no_columns():
    """Columns of no poses are empty."""
    none = Poses.from_arrays(np.zeros((0, 6)), {}, turning(6))
    columns = UnattributedSpace("strain").contact_columns(
        none, np.zeros((0, 4, 4)), None, np.zeros(0), np.zeros((0, 6))
    )
    assert columns.shape == (0, 6, 5)
