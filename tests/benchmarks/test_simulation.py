"""The simulation is compared with pybullet's own call on the very rays that it casts."""

import numpy as np

from benchmarks.scenes import CONFIG
from benchmarks.simulation import rays_of, simulation
from scalar.simulation import load_config, simulate
from scalar.simulation.world import World


def test_both_cast_the_same_rays():
    """The rays of the bare call end on the target planes where the simulation says, to rounding."""
    config = load_config(CONFIG)
    config["poses_per_plane"], config["truth_poses"] = 3, 1
    scene = simulate(config, base_dir=CONFIG.parent)
    starts, ends = rays_of(scene, 0.5)
    with World(scene.workcell.target_planes) as world:
        hit, fraction = world.cast(starts, ends)
    assert (hit >= 0).all()
    assert np.allclose(0.5 * fraction, scene.ranges.ravel(), rtol=0, atol=1e-12)


def test_the_table_states_both_goals(capsys):
    """For each number of points in a scan there is a rate, beside what is asked for, and the share of finding poses."""
    simulation(1)
    said = capsys.readouterr().out
    assert said.count("of the bare rate (at least 0.8)") == 2
    assert said.count("of a simulation from nothing (below 0.5)") == 2
