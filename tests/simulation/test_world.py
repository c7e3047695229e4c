"""Rays and contacts of the pybullet world against geometry worked out by hand."""

from dataclasses import replace

import numpy as np
import pybullet
import pytest

from scalar.simulation import SimulationError
from scalar.simulation.body import Capsule, body_of
from scalar.simulation.target_planes import target_plane_from_mapping
from scalar.simulation.world import RAYS_PER_BATCH, World
from tests.simulation.geometry import distance_to_box

ROUNDING = 4e-15  # m; rays of about a metre in double precision


def random_target_plane(rng, **changes):
    """Return a target plane of 1 m, anywhere within a metre, in any direction."""
    plane = {
        "name": "target_plane",
        "normal": rng.normal(size=3),
        "distance_m": rng.uniform(-1, 1),
        "centre_m": rng.uniform(-0.5, 0.5, 3),
        "size_m": [1.0, 1.0],
        "thickness_m": 0.02,
    }
    return target_plane_from_mapping(plane | changes, shoulder=np.array([0.0, 0.0, 5.0]))


def rays_towards(target_plane, rng, count):
    """Return starts and ends (count, 3) of rays that pass through the target plane, 0.1 to 0.8 m long before it."""
    across = rng.uniform(-0.45, 0.45, (count, 2))
    targets = target_plane.centre + across @ target_plane.axes[:, :2].T
    away = rng.normal(size=(count, 3))
    away += (1.0 + np.abs(away @ target_plane.axes[:, 2]))[:, None] * target_plane.axes[
        :, 2
    ]  # off the face, up to steep
    away /= np.linalg.norm(away, axis=1)[:, None]
    starts = targets + rng.uniform(0.1, 0.8, count)[:, None] * away
    return starts, targets - 0.2 * away


@pytest.mark.parametrize("seed", range(5))
def test_rays_end_on_the_plane(seed):
    """A ray meets a target plane of any place and tilt where the line meets the plane n . p = d, to rounding."""
    rng = np.random.default_rng(seed)
    target_plane = random_target_plane(rng)
    starts, ends = rays_towards(target_plane, rng, 2000)
    with World([target_plane]) as world:
        hit, fraction = world.cast(starts, ends)
        assert (hit == world.target_plane_ids[0]).all()
    along = ends - starts
    expected = (target_plane.distance - starts @ target_plane.normal) / (along @ target_plane.normal)
    length = np.linalg.norm(along, axis=1)
    np.testing.assert_allclose(fraction * length, expected * length, atol=ROUNDING, rtol=0)


def test_a_meshed_target_plane_is_as_exact_as_a_box():
    """Rays meet the triangles of a concave mesh, of which bent target planes are made, to rounding too."""
    rng = np.random.default_rng(7)
    target_plane = random_target_plane(rng)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * target_plane.size / 2
    vertices = target_plane.centre + corners @ target_plane.axes[:, :2].T
    meshed = target_plane.moved(mesh=(vertices, np.array([[0, 1, 2], [0, 2, 3]])))
    starts, ends = rays_towards(target_plane, rng, 500)
    with World([meshed]) as world:
        hit, fraction = world.cast(starts, ends)
        assert (hit == world.target_plane_ids[0]).all()
    expected = (target_plane.distance - starts @ target_plane.normal) / (
        (ends - starts) @ target_plane.normal
    )
    np.testing.assert_allclose(fraction, expected, atol=ROUNDING, rtol=0)


@pytest.mark.parametrize("count", [1, RAYS_PER_BATCH, 16_384, 40_000])
def test_every_ray_is_answered_in_its_place(count):
    """There are as many answers as rays, in their order, even beyond the 16,384 rays of which pybullet loses one."""
    floor = random_target_plane(
        np.random.default_rng(0), normal=[0, 0, 1], distance_m=0.0, centre_m=[0, 0, 0]
    )
    heights = np.linspace(0.1, 0.9, count)
    starts = np.column_stack([np.zeros(count), np.zeros(count), heights])
    ends = starts - [0.0, 0.0, 1.0]
    with World([floor]) as world:
        hit, fraction = world.cast(starts, ends)
    assert len(hit) == len(fraction) == count
    np.testing.assert_allclose(fraction, heights, atol=ROUNDING, rtol=0)


def test_a_lost_ray_is_an_error(monkeypatch):
    """If pybullet answers fewer rays than were asked, an error says so and nothing is returned."""
    monkeypatch.setattr("scalar.simulation.world.RAYS_PER_BATCH", 16_384)
    ends = np.tile([0.0, 0.0, 1.0], (16_384, 1))
    with World() as world, pytest.raises(SimulationError, match="16384 rays were asked and 16383 answered"):
        world.cast(np.zeros_like(ends), ends)


def test_a_ray_past_the_edge_meets_nothing():
    """A ray past the edge of a target plane meets nothing, because the plane has an end."""
    floor = random_target_plane(
        np.random.default_rng(0), normal=[0, 0, 1], distance_m=0.0, centre_m=[0, 0, 0]
    )
    starts = np.array([[0.49, 0.0, 0.5], [0.51, 0.0, 0.5]])
    with World([floor]) as world:
        hit, _ = world.cast(starts, starts - [0.0, 0.0, 1.0])
    assert hit.tolist() == [world.target_plane_ids[0], -1]


def test_the_client_is_closed_whatever_happens():
    """Leaving the block disconnects pybullet, after an error as well."""
    world = World()
    with pytest.raises(ValueError, match="on purpose"), world:
        raise ValueError("on purpose")
    assert world.client == -1
    clients = []
    for _ in range(5):
        with World() as world:
            clients.append(world.client)
            assert pybullet.isConnected(world.client)
        assert not pybullet.isConnected(clients[-1])


def test_contact_is_told_where_geometry_tells_it(paper):
    """The arm touches a target plane where a capsule comes nearer to it than the clearance."""
    workcell = paper.workcell
    body = body_of(workcell.nominal, paper.config["body"])
    # No sensor box, so that what is left is capsules, whose distances are quickly told a second way.
    body = replace(body, solids=tuple(s for s in body.solids if isinstance(s, Capsule)), pairs=())
    rng = np.random.default_rng(5)
    q = rng.uniform(workcell.arm.limits[:, 0], workcell.arm.limits[:, 1], (150, workcell.arm.n))
    told = []
    with World(workcell.target_planes) as world:
        world.place_arm(workcell.arm, body)
        for row in q:
            told.append(world.touching(row.tolist()) == "target_plane")
    fine = 1e-3  # m; a nearer decision than this is left open: the axes are sampled
    for row, touches in zip(q, told, strict=True):
        gap = min(_gaps(workcell, body, row))
        if abs(gap - body.clearance) > fine:
            assert touches == (gap < body.clearance)
    assert 10 < sum(told) < 140  # both answers were put to the test


def _gaps(workcell, body, q):
    """Yield the distance of each capsule but the base's from each target plane, at q."""
    frames = [workcell.arm.T_base_0]
    for i, angle in enumerate(q):
        T = workcell.arm.joint_origin(i).copy()
        c, s = np.cos(angle), np.sin(angle)
        T[:3, :3] = T[:3, :3] @ [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        frames.append(frames[-1] @ T)
    frames.append(frames[-1] @ workcell.arm.T_n_flange)
    for solid in body.solids:
        if solid.link < 0:
            continue
        T = frames[solid.link + 1]
        axis = solid.start + np.linspace(0, 1, 400)[:, None] * (solid.end - solid.start)
        points = axis @ T[:3, :3].T + T[:3, 3]
        for target_plane in workcell.target_planes:
            size = np.array([*target_plane.size, target_plane.thickness])
            middle = target_plane.centre - target_plane.axes[:, 2] * target_plane.thickness / 2
            yield distance_to_box(points, target_plane.axes, middle, size).min() - solid.radius
