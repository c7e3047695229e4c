"""The compiled contact vectors, tangents, scatters and ends of chains are those of NumPy."""

import numpy as np
import pytest

from scalar import kernels
from scalar.estimation.initial_estimate import sensor_and_target
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.least_squares import fit
from scalar.estimation.normal_equations import NormalEquations
from scalar.estimation.outlying_points import scatter_about_lines
from scalar.estimation.prepare import prepare
from scalar.geometry.planes import Planes, tangent_basis
from scalar.sensors import profile
from tests.random_scene import make_scene
from tests.test_kernels import needs_library, without_library


@needs_library
def test_tangents_are_orthonormal_and_those_of_numpy(monkeypatch):
    """For random normals, and for those with components of the same size, both give the same two unit vectors across the normal."""
    normals = np.vstack(
        [np.random.default_rng(0).normal(size=(50, 3)), np.eye(3), np.ones((1, 3)), [[1.0, -1.0, 0.0]]]
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    compiled = tangent_basis(normals)
    frames = np.concatenate([normals[:, None], compiled], axis=1)
    np.testing.assert_allclose(
        frames @ np.swapaxes(frames, 1, 2), np.broadcast_to(np.eye(3), frames.shape), atol=1e-15
    )
    without_library(monkeypatch)
    np.testing.assert_allclose(compiled, tangent_basis(normals), atol=1e-15)


@needs_library
def test_contact_vectors_are_those_of_numpy(monkeypatch):
    """For random poses and planes the contact vectors agree to rounding."""
    rng = np.random.default_rng(1)
    T, index = rng.normal(size=(20, 4, 4)), rng.integers(0, 3, 20)
    planes = Planes.at(["a", "b", "c"], rng.normal(size=(3, 3)), rng.normal(size=3))
    compiled = profile.contact_vectors(T, planes, index)
    without_library(monkeypatch)
    np.testing.assert_allclose(compiled, profile.contact_vectors(T, planes, index), rtol=1e-13, atol=1e-14)


@needs_library
@pytest.mark.parametrize("k", [3, 5])
def test_scatters_are_those_of_numpy(k, monkeypatch):
    """With and without further functions of the points, and for rows without length, the scatter within scans agrees."""
    rng = np.random.default_rng(2)
    R, c, full = rng.normal(size=(20, k, k)), rng.normal(size=(20, 3)), rng.normal(size=(20, k))
    R[0], R[1, :, 0] = 0.0, 0.0
    for added in (None, full):
        compiled = profile.scatter_within(R, c, np.arange(20), added)
        with monkeypatch.context() as patch:
            without_library(patch)
            expected = profile.scatter_within(R, c, np.arange(20), added)
        np.testing.assert_allclose(compiled[0], expected[0], rtol=1e-9, atol=1e-14)
        np.testing.assert_array_equal(compiled[1], expected[1])


@needs_library
def test_the_scatter_about_lines_is_that_of_numpy(monkeypatch):
    """The points of every scan scatter alike about its line of least squares."""
    dataset = make_scene(seed=3, poses_per_plane=4).dataset
    compiled = scatter_about_lines(dataset)
    without_library(monkeypatch)
    np.testing.assert_allclose(compiled, scatter_about_lines(dataset), rtol=1e-9)


@needs_library
def test_sensor_poses_are_those_of_the_frames(monkeypatch):
    """The poses of the sensor are those that the frames of the chain give, which are computed when they are asked for."""
    prepared = prepare(make_scene(seed=4, poses_per_plane=20).dataset)
    model, residuals = prepared.coarse, prepared.residuals
    found = Kinematics.of(model, residuals.poses, residuals.bases)
    without_library(monkeypatch)
    expected = Kinematics.of(model, residuals.poses, residuals.bases)
    np.testing.assert_allclose(found.T_base_sensor, expected.T_base_sensor, atol=1e-14)
    np.testing.assert_allclose(found.frames, expected.frames, atol=1e-14)


@needs_library
@pytest.mark.parametrize("kind", ["line-laser", "probe"])
def test_normal_equations_are_the_products_of_the_rows(kind):
    """J'J, J'r and r'r by the free coordinates are the products of rows and Jacobian; the priors are not among these rows."""
    prepared = prepare(make_scene(kind=kind, seed=5, poses_per_plane=20).dataset)
    residuals, model, free = prepared.residuals, prepared.initial.model, prepared.free
    residual, jacobian = residuals.linearise(model)
    expected = NormalEquations.of(residual, jacobian[:, free])
    found = residuals.normal_equations(model, free)
    assert residuals.normal_equations(model, free) is found
    np.testing.assert_allclose(found.gram, expected.gram, rtol=1e-9, atol=1e-13 * expected.gram.max())
    np.testing.assert_allclose(
        found.gradient, expected.gradient, rtol=1e-9, atol=1e-12 * np.abs(expected.gradient).max()
    )
    assert found.squares == pytest.approx(expected.squares, rel=1e-12)
    assert found.rows == expected.rows


@needs_library
@pytest.mark.parametrize("kind", ["line-laser", "probe"])
def test_a_fit_of_sensor_and_planes_alone_ends_at_the_optimum_of_minpack(kind, monkeypatch):
    """While the arm keeps its geometry, its flanges are computed once, and the fit ends where SciPy's does."""
    prepared = prepare(make_scene(kind=kind, seed=6, poses_per_plane=20).dataset)
    residuals, start = prepared.residuals, prepared.coarse
    free = sensor_and_target(residuals, start)
    ours = fit(residuals, start, free)
    assert ours.message == "compiled" and ours.converged
    without_library(monkeypatch)
    theirs = fit(residuals, start, free)
    assert theirs.message != "compiled"
    assert ours.chi_squared == pytest.approx(theirs.chi_squared, rel=1e-10)
    off = (ours.model.vector - theirs.model.vector)[free]
    assert np.max(np.abs(off) / np.sqrt(np.diag(theirs.covariance))) < 1e-6


@needs_library
def test_addresses_are_those_of_numpy():
    """Arrays that are read-only, empty or strided have the addresses that NumPy states."""
    table = np.arange(12.0).reshape(3, 4)
    fixed = table.copy()
    fixed.setflags(write=False)
    for array in (table, fixed, table[1:], table[:, 1:], np.zeros(0)):
        assert kernels.address(array) == array.ctypes.data
