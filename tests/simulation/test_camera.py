"""The camera sees what it is pointed at, and its depths lead back to the points."""

import numpy as np
import pytest

from scalar.simulation.camera import Camera
from scalar.simulation.render import render_scene
from scalar.simulation.scene import simulate
from scalar.simulation.shapes import box, drum, frame_along, sheet, tube

TOWARDS = np.array([-0.5, -0.8, 0.4])


@pytest.fixture(scope="module")
def camera():
    """Return a camera on a cube about the origin, 2 m wide."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    return corners, Camera.fitted(corners, TOWARDS, 400, 300)


def test_a_fitted_camera_sees_all_and_wastes_little(camera):
    """Every corner is in the picture, and the picture is filled in one direction."""
    corners, fitted = camera
    seen = fitted.pixels(corners)
    assert (seen >= 0).all() and (seen <= [400, 300]).all()
    assert (np.ptp(seen, axis=0) / [400, 300]).max() > 0.9
    assert fitted.towards @ TOWARDS / np.linalg.norm(TOWARDS) == pytest.approx(1, abs=0.02)


def test_depths_lead_back_to_the_points(camera):
    """A depth picture of one constant depth unprojects to points that project onto their own pixels."""
    _, fitted = camera
    depth = np.full((300, 400), 0.7)
    points = fitted.points(depth)
    centres = np.stack(np.meshgrid(np.arange(400) + 0.5, np.arange(300) + 0.5), axis=-1).reshape(-1, 2)
    assert np.allclose(fitted.pixels(points), centres, atol=1e-6)
    assert np.allclose(fitted.clip(points)[:, 2], 2 * 0.7 - 1, atol=1e-9)


def volume(mesh) -> float:
    """Return the volume that triangles turned outward enclose: the divergence theorem."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return float(np.sum(a * np.cross(b, c)) / 6)


def test_solids_have_the_volume_of_their_formula():
    """Solids are closed and turned outward, and their volume differs from the formula's by less than a per cent, the chords of facets."""
    size = np.array([0.2, 0.3, 0.5])
    assert volume(box(size)) == pytest.approx(size.prod())
    r, start, end = 0.1, np.array([0.2, 0.1, 0.3]), np.array([0.5, 0.1, 0.7])
    assert volume(tube(start, end, r)) == pytest.approx(np.pi * r**2 * 0.5 + 4 / 3 * np.pi * r**3, rel=0.02)
    assert volume(drum(0.1, 0.2)) == pytest.approx(np.pi * 0.1**2 * 0.4, rel=0.02)


@pytest.mark.parametrize(
    "mesh", [box(np.ones(3)), drum(0.1, 0.2), tube(np.zeros(3), np.ones(3), 0.1), sheet(np.eye(3))]
)
def test_normals_are_unit_and_point_out(mesh):
    """Each vertex normal is of length 1 and on the outer side of the triangles that meet there."""
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1)
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    flat = np.cross(b - a, c - a)
    large = np.linalg.norm(flat, axis=1) > 1e-9
    of_vertices = mesh.normals[mesh.triangles].mean(axis=1)
    assert (np.sum(flat * of_vertices, axis=1)[large] > 0).all()


def test_a_frame_lies_along_its_segment():
    """The frame is a rotation whose z axis points to the end of the segment, in every direction."""
    rng = np.random.default_rng(1)
    for start, end in rng.normal(size=(20, 2, 3)):
        T = frame_along(start, end)
        assert np.allclose(T[:3, :3].T @ T[:3, :3], np.eye(3)) and np.linalg.det(T[:3, :3]) == pytest.approx(
            1
        )
        assert np.allclose(T @ [0, 0, np.linalg.norm(end - start), 1], [*end, 1])


def test_names_stand_where_their_parts_are(paper_scene):
    """The places of target planes, base and scanner lie in the picture, and the laser is red beside its scanner."""
    scene = paper_scene
    picture = render_scene(scene, 0, width=320, height=240, views=1)
    assert set(picture.places) == {"floor", "wall_x", "wall_y", "base", "scanner"}
    for x, y in picture.places.values():
        assert 0 < x < 320 and 0 < y < 240
    red = picture.image[..., 0].astype(int) - picture.image[..., 1] > 60
    rows, columns = np.nonzero(red)
    x, y = picture.places["scanner"]
    assert np.hypot(columns - x, rows - y).min() < 25  # the bracket or a link may stand before the fan's apex


@pytest.fixture(scope="module")
def paper_scene(request):
    """Return a small scene of the paper's workcell."""
    from scalar.simulation.config import load_config

    path = request.config.rootpath / "configs/scenes/paper.yaml"
    return simulate(load_config(path) | {"poses_per_plane": 3, "truth_poses": 10}, base_dir=path.parent)
