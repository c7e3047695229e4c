"""Every effect's columns are the derivatives of the exact model by its coefficients."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.effects.acquisition import plane_centre
from scalar.effects.flexible.measured_space import UnattributedSpace
from scalar.effects.flexible.proposals import errors_of_instrument
from scalar.effects.places import PointEffect
from scalar.effects.plane_moved import PlaneMoved
from scalar.effects.range_error import ScannerError
from scalar.estimation.displacement import kinematics_at
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals, extra_basis_of
from scalar.sensors import measure
from scalar.sensors.profile import contact_vectors
from tests.effects.everything import describe, every_effect, optional_columns, with_random_coefficients
from tests.effects.injected import make_cell
from tests.random_scene import make_scene
from tests.turning import turning

RELATIVE = 1e-6  # of a column's length, against central differences
COUNT = len(every_effect(make_cell(poses_per_plane=6, points_per_scan=4).dataset, np.random.default_rng(0)))


def model_with(dataset, effects, seed):
    """Return residuals and a model away from its references, with effects at non-zero coefficients."""
    rng = np.random.default_rng(seed)
    measurement = measure(dataset, extra_basis_of(effects))
    T = dataset.robot.flange(dataset.q) @ dataset.sensor.T_flange_sensor
    target = measurement.fitted_target(T, measurement.initial_target(dataset))
    model = Model.at(dataset.robot, dataset.sensor.T_flange_sensor, target, effects)
    away = model.vector.copy()
    before = model.blocks["effects"].start
    away[:before] += 1e-2 * rng.standard_normal(before)
    model = model.with_vector(away)
    residuals = Residuals.of(dataset, model, measurement)
    return residuals.reweighted(model), model


def by_central_differences(residuals, model, where, step=1e-5):
    """Return the Jacobian by some of the coordinates, each moved by a step either way."""
    columns = []
    for i in range(where.start, where.stop):
        h = np.zeros(len(model.vector))
        h[i] = step
        ahead, behind = (residuals.residual(model.with_vector(model.vector + s * h)) for s in (1, -1))
        columns.append((ahead - behind) / (2 * step))
    return np.column_stack(columns)


def compare(residuals, model, where=None, relative=RELATIVE):
    """Assert that the columns of some coordinates, or of all effects, agree with central differences."""
    where = model.blocks["effects"] if where is None else where
    J = residuals.linearise(model)[1][:, where]
    numeric = by_central_differences(residuals, model, where)
    for name, exact, near in zip(model.names[where], J.T, numeric.T, strict=True):
        assert np.linalg.norm(exact) > 0, f"{name}: a column of nothing"
        assert np.linalg.norm(exact - near) < relative * np.linalg.norm(exact), name


@pytest.mark.parametrize("axis", ["ray", "z"])
@pytest.mark.parametrize("which", range(COUNT))
def test_columns_are_derivatives_of_the_exact_model(which, axis):
    """The analytic columns of one effect agree with central differences, for errors along the ray and z."""
    cell = make_cell(
        seed=3, poses_per_plane=6, points_per_scan=(5, 9), columns=optional_columns, error_axis=axis
    )
    effect = every_effect(cell.dataset, np.random.default_rng(which))[which]
    compare(*model_with(cell.dataset, (effect,), which))


@pytest.mark.parametrize("which", range(COUNT))
def test_no_poses_have_no_columns(which):
    """At none of no poses does an effect fail: `scalar correct` looks at the poses that it did not reach, of which there may be none."""
    cell = make_cell(seed=3, poses_per_plane=6, points_per_scan=6, columns=optional_columns)
    effect = every_effect(cell.dataset, np.random.default_rng(which))[which]
    _, model = model_with(cell.dataset, (effect,), which)
    none = Poses.from_frame(cell.dataset.poses.iloc[:0], turning(6), order_is_row=True)
    assert kinematics_at(model, none).T_base_sensor.shape == (0, 4, 4)


def test_columns_of_many_effects_at_once():
    """With an effect at every place of the arm at once, the whole Jacobian is the derivative, columns of robot and sensor included."""
    cell = make_cell(seed=4, poses_per_plane=6, points_per_scan=7, columns=optional_columns)
    effects = every_effect(cell.dataset, np.random.default_rng(5))
    residuals, model = model_with(
        cell.dataset, tuple(e for e in effects if not isinstance(e, PointEffect)), 6
    )
    for block in ("geometry", "sensor", "effects"):
        compare(residuals, model, model.blocks[block])


def test_columns_beside_bent_target_planes_and_range_errors():
    """With effects on points and target planes, the columns of robot and sensor are right within a few per cent, the slope of what is bent."""
    cell = make_cell(seed=4, poses_per_plane=6, points_per_scan=7, columns=optional_columns)
    effects = [e for e in every_effect(cell.dataset, np.random.default_rng(5)) if isinstance(e, PointEffect)]
    residuals, model = model_with(cell.dataset, tuple(effects), 6)
    compare(residuals, model)
    for block in ("geometry", "sensor"):
        compare(residuals, model, model.blocks[block], 0.05)


@pytest.mark.parametrize("kind", ["probe", "tracker"])
def test_columns_for_single_points(kind):
    """The columns of a probe and of a tracker are derivatives too, for every effect that acts on them."""
    scene = make_scene(kind=kind, seed=7, poses_per_plane=7)
    rng = np.random.default_rng(8)
    extra = optional_columns(rng, scene.dataset.n_poses, 6)
    dataset = replace(scene.dataset, poses=scene.dataset.poses.assign(**extra))
    laser = make_cell(seed=7, poses_per_plane=7, columns=optional_columns)
    for effect in [*every_effect(laser.dataset, rng), *errors_of_instrument(dataset)]:
        of_profiles = isinstance(effect, ScannerError)
        of_planes = isinstance(effect, PointEffect) and not isinstance(effect, UnattributedSpace)
        if of_profiles or (of_planes and kind == "tracker"):
            continue
        if effect.name == "sensor_slip" and effect.turns:
            continue  # a point has no orientation
        if effect.name == "unattributed" and getattr(effect, "turns", False):
            continue
        compare(*model_with(dataset, (with_random_coefficients(effect, rng),), 9))


@pytest.mark.parametrize("which", range(COUNT))
def test_columns_at_a_pose_depend_on_that_pose_alone(which):
    """Of other poses too: a column that is scaled by what was measured would correct a program by another amount."""
    dataset = make_cell(poses_per_plane=6, points_per_scan=4, columns=optional_columns).dataset
    effect = every_effect(dataset, np.random.default_rng(0))[which]
    poses = dataset.known_poses
    for third in range(3):
        keep = np.arange(dataset.n_poses) % 3 == third
        some = Poses(
            poses.q[keep], poses.order[keep], {name: values[keep] for name, values in poses.columns.items()}
        )
        for columns in ("joint_basis", "geometry_basis", "base_screws", "sensor_screws"):
            if hasattr(effect, columns):
                of_all, of_some = (getattr(effect, columns)(dataset.robot, at) for at in (poses, some))
                np.testing.assert_allclose(
                    of_some, of_all[keep], rtol=1e-12, atol=1e-15, err_msg=describe(effect)
                )


def test_titles_of_effects_are_unique():
    """No two of the effects under test have the same title."""
    effects = every_effect(make_cell(poses_per_plane=6).dataset, np.random.default_rng(0))
    names = [describe(effect) + str(effect.to_mapping()) for effect in effects]
    assert len(set(names)) == len(names)


def test_the_columns_of_a_creep_are_a_share_of_those_of_the_moved_plane():
    """A creep's columns are those of the plane that stands elsewhere all the time, times what has crept by each pose; that plane has no course."""
    scene = make_cell(seed=5, poses_per_plane=8, points_per_scan=6, columns=optional_columns)
    poses = scene.dataset.known_poses
    residuals, model = model_with(scene.dataset, (), 0)
    T, index = residuals.kinematics(model).T_base_sensor, residuals.measurement.target_index
    where = T, model.target, index, contact_vectors(T, model.target, index)
    creep = PlaneMoved("floor", 5.0, None, plane_centre(scene.dataset, "floor"), 9.0)
    always, shares = creep.constant_and_shares(poses)
    expected = creep.profile(poses.order)[:, None, None] * always.contact_columns(poses, *where)
    np.testing.assert_array_equal(shares, np.clip((poses.order - 5.0) / 9.0, 0.0, 1.0))
    np.testing.assert_allclose(creep.contact_columns(poses, *where), expected, rtol=1e-14)
    assert always.constant_and_shares(poses) is None and expected.any()
