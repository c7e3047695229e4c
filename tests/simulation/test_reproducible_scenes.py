"""The same seed gives the same scene, and a scene with fewer poses, points or less noise has part of the same draws."""

import numpy as np
from scipy import stats

from scalar.simulation import plan_poses, simulate, write_scene
from scalar.units import DEG
from tests.simulation.conftest import scene_config
from tests.simulation.noise_checks import ALPHA, noise


def test_same_seed_same_bytes(tmp_path):
    """Two runs of one config write the same bytes; another seed writes others."""
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        write_scene(simulate(scene_config("ur10e", seed=seed)), tmp_path / name)
    files = sorted(path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*.*"))
    assert {path.name for path in files} == {
        "dataset.yaml", "poses.csv", "scans.csv", "truth.json", "truth_poses.csv",
    }  # fmt: skip
    for file in files:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    assert (tmp_path / "a/dataset/poses.csv").read_bytes() != (tmp_path / "c/dataset/poses.csv").read_bytes()


def test_a_sweep_of_noise_scales_one_pattern(paper):
    """Twice the noise is twice the same errors, at the same poses."""
    config = scene_config("paper")
    config["sensor"]["selection"] = "even"
    plan = plan_poses(config)
    once, twice = (
        simulate(config | {"noise": noise(range_noise_std_m=std)}, plan=plan).points - paper.points
        for std in (1e-4, 2e-4)
    )
    np.testing.assert_allclose(twice, 2 * once, atol=1e-15)


def test_a_sweep_of_poses_keeps_the_first(paper):
    """Fewer poses a plane are the first of each plane, in the same order, noise and all."""
    many = simulate(scene_config("paper", poses_per_plane=9))
    few = simulate(scene_config("paper", poses_per_plane=4))
    # Which rows of `many` are the first four of their plane is told by their q.
    rows = [int(np.flatnonzero((many.q == q).all(1))[0]) for q in few.q]
    assert rows == sorted(rows)
    np.testing.assert_array_equal(few.points, many.points[rows])


def test_a_sweep_of_points_keeps_a_subset():
    """With fewer points a scan, chosen at random, they are some of the points there were, noise and all."""
    config = scene_config("paper")
    plan = plan_poses(config)
    many = simulate(config, plan=plan)
    config["sensor"]["points_per_scan"] = 10
    few = simulate(config, plan=plan)
    for a, b in zip(few.points, many.points, strict=True):
        assert {tuple(point) for point in a} < {tuple(point) for point in b}
    assert (np.diff(few.angles, axis=1) > 0).all()


def test_random_points_come_from_all_over_the_fan():
    """Each ray of the fan is equally likely to be chosen."""
    scene = simulate(scene_config("paper", poses_per_plane=60))
    sensor = scene.config["sensor"]
    steps = (scene.angles / DEG + 15.0) / 30.0 * (sensor["rays"] - 1)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    counts, _ = np.histogram(steps, bins=10, range=(-0.5, sensor["rays"] - 0.5))
    assert stats.chisquare(counts).pvalue > ALPHA  # fewer than free draws would vary: none is drawn twice


def test_evaluation_poses_do_not_depend_on_the_seed(paper):
    """Every scene of one robot is judged on the same joint angles."""
    other = simulate(scene_config("paper", seed=99)).truth_poses
    columns = [f"q{i + 1}" for i in range(6)]
    np.testing.assert_array_equal(other[columns], paper.truth_poses[columns])
