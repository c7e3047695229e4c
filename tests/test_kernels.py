"""The compiled inner loops give the same numbers as their counterparts in NumPy, and an outdated library is not used."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scalar import kernels
from scalar.data.poses import Poses
from scalar.errors import Undetermined
from scalar.estimation import residuals
from scalar.estimation.calibrate import calibrate
from scalar.estimation.data_sheet_priors import data_sheet_priors
from scalar.estimation.least_squares import fit
from scalar.estimation.prepare import prepare
from scalar.geometry.robot import link_transforms
from scalar.kernels.linear_start import linear_start
from scalar.sensors import measure, profile
from scalar.sensors.compression import compress, compress_keeping_q
from scalar.sensors.linear_guess import guesses
from scalar.sensors.scans import as_scans
from tests.random_scene import make_scene

needs_library = pytest.mark.skipif(kernels.LIBRARY is None, reason="no compiled kernels here: no C compiler")


def scans(seed, noise):
    """Return scans of one, two and many points of a line: the points, where each scan starts, and contact vectors."""
    rng = np.random.default_rng(seed)
    starts = np.array([0, 1, 3, 40, 300])
    x = rng.uniform(-0.1, 0.1, 300)
    points = np.column_stack([x, 0.4 + 0.2 * x + noise * rng.normal(size=300)])
    return points, starts, rng.normal(size=(4, 3))


def without_library(monkeypatch):
    """Switch the compiled library off, so that NumPy computes everything."""
    for module in (kernels, residuals):
        monkeypatch.setattr(module, "LIBRARY", None)


@needs_library
@given(st.integers(1, 8), st.integers(1, 5), st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_frames_are_the_products_of_link_transforms(n, N, seed):
    """For any chain, ``T_base_i`` is the product of the transforms of the links up to i, to rounding."""
    rng = np.random.default_rng(seed)
    geometry, q, T = rng.normal(size=(5, n)), rng.normal(size=(N, n)), np.eye(4)
    T[:3, 3] = rng.normal(size=3)
    found = kernels.frames(q, geometry, T)
    assert found is not None
    links, expected = link_transforms(geometry, q), np.broadcast_to(T, (N, 4, 4))
    np.testing.assert_array_equal(found[:, 0], expected)
    for i in range(n):
        expected = expected @ links[:, i]
        np.testing.assert_allclose(found[:, i + 1], expected, atol=1e-12)


@pytest.mark.parametrize("robot", ["vs060", "ur10e"])
def test_frames_and_screws_with_a_geometry_of_each_pose(robot, monkeypatch):
    """With offsets of the geometry that differ from pose to pose, frames and screws are those of NumPy, and further columns are zero."""
    arm, rng = make_scene(robot, poses_per_plane=3).dataset.robot, np.random.default_rng(0)
    q, offsets = rng.normal(size=(7, arm.n_joints)), 0.1 * rng.normal(size=(7, 5, arm.n_joints))
    for each in (None, offsets):
        with monkeypatch.context() as patch:
            without_library(patch)
            frames = arm.frames(q, each)
            expected = arm.screws(frames, each, 4)
        np.testing.assert_allclose(arm.frames(q, each), frames, atol=1e-12)
        np.testing.assert_allclose(arm.screws(frames, each, 4), expected, atol=1e-12)
        assert not expected[:, :, -4:].any()


@needs_library
@pytest.mark.parametrize("axis", ["ray", "z"])
@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_scans_are_compressed_alike(axis, noise, monkeypatch):
    """For weighted and unweighted scans of one, two and many points, with and without noise, ``R'R`` and the rank are those of NumPy's factors."""
    points, starts, c = scans(seed=3, noise=noise)
    for contact in (None, c):
        compiled = profile.line_factors(points, starts, contact, axis, 2e-4)
        with monkeypatch.context() as patch:
            patch.setattr(kernels, "LIBRARY", None)
            expected = profile.line_factors(points, starts, contact, axis, 2e-4)
        np.testing.assert_allclose(compiled, expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max())
        np.testing.assert_array_equal(compiled == 0, expected == 0)


@needs_library
@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_any_functions_of_the_points_are_compressed_alike(noise):
    """For functions up to the fourth power and scans of one, two and many points, ``R'R`` is that which NumPy computes."""
    points, starts, _ = scans(seed=5, noise=noise)
    basis = profile.point_basis(("1", "x", "z", "xx", "xz", "uz", "rz", "dz", "uz:04"), points, "ray")
    compiled, expected = compress(basis, starts), compress_keeping_q(basis, starts)[0]
    for own, numpy in zip(compiled, expected, strict=True):
        np.testing.assert_allclose(own.T @ own, numpy.T @ numpy, rtol=1e-11, atol=1e-13)


@needs_library
@pytest.mark.parametrize("axis", ["ray", "z"])
@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_profiles_of_scans_are_those_of_numpy(axis, noise, monkeypatch):
    """Every function of a point that an effect may need has the same components along 1, t and t^2, for scans of any length."""
    points, starts, c = scans(seed=4, noise=noise)
    names = ("1", "x", "z", "xx", "xz", "zz", "ux", "uz", "rx", "rz", "dx", "dz", "ux:30", "uz:12", "uz:04")
    compiled = profile.profile_factors(names, points, starts, c, axis, 2e-4)
    monkeypatch.setattr(kernels, "LIBRARY", None)
    expected = profile.profile_factors(names, points, starts, c, axis, 2e-4)
    np.testing.assert_allclose(compiled[2:], expected[2:], rtol=1e-9, atol=1e-11 * np.abs(expected).max())
    np.testing.assert_allclose(compiled[:2, :1], expected[:2, :1], rtol=1e-11)
    np.testing.assert_array_equal(np.any(compiled[:2], axis=2), np.any(expected[:2], axis=2))


@needs_library
@pytest.mark.parametrize("kind", ["line-laser", "probe"])
def test_rows_and_jacobian_are_those_of_numpy(kind, monkeypatch):
    """At a model away from its references, rows and every column agree to rounding."""
    prepared = prepare(make_scene(kind=kind, seed=2, poses_per_plane=20).dataset)
    of, vector = prepared.residuals, prepared.coarse.vector
    model = prepared.coarse.with_vector(vector + 1e-2 * np.random.default_rng(0).normal(size=len(vector)))
    assert of.plane_problem(model) is not None
    compiled = of.linearise(model)
    assert np.array_equal(of.residual(model), compiled[0])
    without_library(monkeypatch)
    expected = of.linearise(model)
    for one, other in zip(compiled, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12 * np.abs(other).max())


@needs_library
@pytest.mark.parametrize("kind", ["line-laser", "probe"])
def test_fits_end_at_the_optimum_of_minpack(kind, monkeypatch):
    """From the initial estimate, with and without priors, costs agree to 1e-10, and values to 1e-6 standard errors of SciPy's."""
    prepared = prepare(make_scene(kind=kind, seed=7, poses_per_plane=30).dataset)
    for start in (prepared.initial.model, with_priors(prepared)):
        ours = fit(prepared.residuals, start, prepared.free)
        assert ours.message == "compiled" and ours.converged
        with monkeypatch.context() as patch:
            without_library(patch)
            theirs = fit(prepared.residuals, start, prepared.free)
        assert theirs.message != "compiled"
        assert ours.chi_squared == pytest.approx(theirs.chi_squared, rel=1e-10)
        off = (ours.model.vector - theirs.model.vector)[prepared.free]
        assert np.max(np.abs(off) / np.sqrt(np.diag(theirs.covariance))) < 1e-6
        np.testing.assert_allclose(
            ours.covariance, theirs.covariance, rtol=1e-6, atol=1e-9 * theirs.covariance.max()
        )


def with_priors(prepared):
    """Return the initial model with priors from the data sheet."""
    model = prepared.initial.model
    return replace(model, priors=data_sheet_priors(model, prepared.free), misfit_ratio=1.7)


@needs_library
def test_ill_conditioned_normal_equations_are_left_to_minpack():
    """If the gauge is free, columns are almost dependent: the library gives up, and SciPy's orthogonal factors end the fit."""
    prepared = prepare(make_scene(seed=2, poses_per_plane=20).dataset)
    everything = np.ones(len(prepared.free), dtype=bool)  # the gauge as well
    found = fit(prepared.residuals, prepared.initial.model, everything)
    assert found.message != "compiled"
    assert (
        found.chi_squared
        <= fit(prepared.residuals, prepared.initial.model, prepared.free).chi_squared * 1.001
    )


@needs_library
@pytest.mark.parametrize("robot", ["vs060", "ur10e"])
def test_linear_guesses_are_those_of_numpy(robot, monkeypatch):
    """From a wrong arm and planes that are 20 degrees off, every guess of the scanner's pose agrees to rounding, as do which planes go with it."""
    data = make_scene(robot, seed=5, plane_tilt=0.35, angle_error=0.02, poses_per_plane=20).dataset
    measurement, T_base_flange = measure(data), data.robot.flange(data.q)
    target = measurement.initial_target(data)

    scans = as_scans(measurement), T_base_flange, target, data.robot.gravity, True
    ours = guesses(*scans)
    without_library(monkeypatch)
    theirs = guesses(*scans)
    assert [guess[1] for guess in ours] == [guess[1] for guess in theirs]
    for (one, _), (other, _) in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


@needs_library
def test_a_guess_of_unclear_rank_is_left_to_numpy():
    """One posture does not determine the nine numbers of a guess: the library gives none, and NumPy says why."""
    data = make_scene(seed=5, poses_per_plane=20).dataset
    measurement = as_scans(measure(data))
    T_base_flange = np.repeat(data.robot.flange(data.q[:1]), data.n_poses, axis=0)
    target = measurement.initial_target(data)
    use = np.ones(data.n_poses, dtype=bool)
    scans = measurement.R, measurement.R_metric, T_base_flange, measurement.target_index, use
    assert linear_start(*scans, target.normals, target.distances, 8) is None
    with pytest.raises(Undetermined, match="first guess"):
        guesses(measurement, T_base_flange, target, data.robot.gravity, thorough=True)


@needs_library
def test_a_calibration_without_the_library_is_the_same(monkeypatch):
    """``calibrate`` frees the same parameters. Values differ by less than 1e-4 standard errors, which themselves agree to 1e-6."""
    dataset = make_scene(seed=4, poses_per_plane=30).dataset
    ours = calibrate(dataset)
    without_library(monkeypatch)
    theirs = calibrate(dataset)
    assert ours.free == theirs.free and ours.fixed == theirs.fixed
    std = np.sqrt(np.diag(theirs.covariance))
    free = np.isin(ours.model.names, ours.free)
    assert np.max(np.abs(ours.model.vector - theirs.model.vector)[free] / std) < 1e-4
    np.testing.assert_allclose(np.sqrt(np.diag(ours.covariance)), std, rtol=1e-6)


@needs_library
def test_a_library_of_another_source_is_not_used(tmp_path, monkeypatch):
    """After a change of the sources NumPy computes until the library is built again, and always while SCALAR_KERNELS is off."""
    folder = Path(kernels.__file__).parent
    library = shutil.copy(folder / "kernels.so", tmp_path / "kernels.so")
    assert kernels.load(library, folder) is not None
    shutil.copytree(folder, tmp_path / "source")
    assert kernels.load(library, tmp_path / "source") is not None
    with (tmp_path / "source" / "scans.h").open("a") as file:
        file.write("\n")
    assert kernels.load(library, tmp_path / "source") is None
    monkeypatch.setenv("SCALAR_KERNELS", "off")
    assert kernels.load(library, folder) is None


@needs_library
@pytest.mark.parametrize("rows", [1, 3, 5])
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 41])
def test_poses_that_do_not_fill_a_group_of_four_count_once(count, rows):
    """Of any number of poses with any number of rows, on planes in turn: rows, Jacobian and normal equations are those of finite differences."""
    prepared = prepare(make_scene(seed=2, poses_per_plane=20).dataset)
    model, rng = prepared.coarse, np.random.default_rng(count)
    index = np.arange(count) % len(model.target.normals)
    q, factors = rng.uniform(-1, 1, (count, model.robot.n_joints)), rng.normal(size=(count, rows, 3))
    problem = residuals.plane_problem(model, Poses.of_joints(q), index, factors)

    def expected(vector):
        at = model.with_vector(vector)
        T = at.robot.flange(q) @ at.T_flange_sensor
        return (factors @ profile.contact(T, at.target, index)[0][:, :, None])[:, :, 0]

    steps = 1e-6 * np.eye(len(model.vector))
    J = np.stack([expected(model.vector + h) - expected(model.vector - h) for h in steps], axis=2) / 2e-6
    found, jacobian = problem.linearise(model.vector)
    np.testing.assert_allclose(found, expected(model.vector), atol=1e-12)
    np.testing.assert_array_equal(problem.residual(model.vector), found)
    np.testing.assert_allclose(jacobian, J, atol=1e-7)

    free = np.flatnonzero(prepared.free)
    gram, gradient, squares = problem.normal_equations(model.vector, free)
    columns = jacobian.reshape(found.size, -1)[:, free]
    np.testing.assert_allclose(gram, columns.T @ columns, atol=1e-11)
    np.testing.assert_allclose(gradient, columns.T @ found.ravel(), atol=1e-11)
    assert squares == pytest.approx(found.ravel() @ found.ravel(), rel=1e-12)
