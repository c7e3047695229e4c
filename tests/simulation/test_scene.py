"""A scene: its noise as declared, its chance reproducible and nested, its truth kept outside."""

import json
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from scalar.data.dataset import read_dataset
from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import InvalidInput
from scalar.simulation import SimulationError, plan_poses, simulate, write_scene
from scalar.simulation.declared import draw_errors, guess_plane
from scalar.simulation.effects import Effects
from scalar.simulation.render import render_scene
from scalar.units import DEG
from tests.simulation.conftest import scene_config
from tests.simulation.geometry import fan_hits, sensor_frames

ALPHA = 1e-6  # a true statement about chance fails once in a million seeds; ours are fixed beforehand
MODEL = {"length_std_m": 0.002, "angle_std_deg": 1.0, "beta_std_deg": 0.5, "sensor": True, "exact": []}


def noise(**changes):
    """Return a complete `noise` block with everything off but `changes`."""
    off = ("range_noise_std_m", "scan_bias_std_m", "joint_noise_std_rad", "range_quantum_m")
    return dict.fromkeys(off, 0.0) | changes


def ranges_of(scene):
    """Return the measured ranges (N, M) [m] along the rays."""
    return np.linalg.norm(scene.points, axis=2)


def assert_standard_normal(z):
    """Assert that z are independent draws of a standard normal, as far as `ALPHA` lets one doubt it."""
    z = np.ravel(z)
    assert stats.kstest(z, "norm").pvalue > ALPHA
    assert 2 * min(stats.chi2.cdf(z @ z, z.size), stats.chi2.sf(z @ z, z.size)) > ALPHA
    assert abs(z[1:] @ z[:-1]) / np.sqrt(z.size) < stats.norm.isf(ALPHA)


def test_noise_free_points_lie_on_their_planes(paper):
    """Without noise, n . p = d for every point, by kinematics that is not pybullet's."""
    assert "noise" not in paper.dataset["sensor"]
    for k, T in enumerate(sensor_frames(paper.workcell.arm, paper.q)):
        target_plane = paper.workcell.target_planes[paper.plane_index[k]]
        points = T[:3, 3] + paper.points[k, :, :1] * T[:3, 0] + paper.points[k, :, 1:] * T[:3, 2]
        np.testing.assert_allclose(points @ target_plane.normal, target_plane.distance, atol=1e-14, rtol=0)


def test_noise_free_points_are_where_their_rays_end(paper):
    """Points are spread evenly over the fan, each at the range of the analytic hit."""
    fan = np.linspace(-15 * DEG, 15 * DEG, paper.config["sensor"]["points_per_scan"])
    measured = np.arctan2(paper.points[..., 0], paper.points[..., 1])
    np.testing.assert_allclose(measured, np.tile(fan, (36, 1)), atol=1e-14)
    for k, T in enumerate(sensor_frames(paper.workcell.arm, paper.q)):
        target_plane = paper.workcell.target_planes[paper.plane_index[k]]
        expected, _, _ = fan_hits(T, fan, target_plane.normal, target_plane.distance)
        np.testing.assert_allclose(ranges_of(paper)[k], expected, atol=1e-14, rtol=0)


def test_range_noise_has_the_declared_spread():
    """Range errors are independent Gaussian of the declared standard deviation, along the ray."""
    scene = simulate(scene_config("paper", noise=noise(range_noise_std_m=2e-4)))
    assert_standard_normal((ranges_of(scene) - scene.ranges) / 2e-4)
    np.testing.assert_allclose(
        np.arctan2(scene.points[..., 0], scene.points[..., 1]), scene.angles, atol=1e-14
    )
    assert scene.dataset["sensor"]["noise"] == 2e-4


def test_noise_along_z_leaves_x_alone(paper):
    """With error_axis z, as a triangulating profiler has it, x is exact and z carries the noise."""
    config = scene_config("paper", noise=noise(range_noise_std_m=2e-4))
    config["sensor"] |= {"error_axis": "z", "selection": "even"}
    scene = simulate(config)
    np.testing.assert_array_equal(scene.points[..., 0], paper.points[..., 0])
    assert_standard_normal((scene.points[..., 1] - paper.points[..., 1]) / 2e-4)


def test_scan_bias_is_common_to_a_scan():
    """A scan's bias shifts all its ranges alike, with the declared spread from scan to scan."""
    scene = simulate(scene_config("paper", poses_per_plane=60, noise=noise(scan_bias_std_m=3e-4)))
    error = ranges_of(scene) - scene.ranges
    np.testing.assert_allclose(error, np.broadcast_to(error[:, :1], error.shape), atol=1e-14, rtol=0)
    assert_standard_normal(error[:, 0] / 3e-4)


def test_joint_noise_moves_the_arm_and_not_the_encoders(paper):
    """With joint noise the dataset's q stays, and the arm stands elsewhere."""
    scene = simulate(scene_config("paper", poses_per_plane=60, noise=noise(joint_noise_std_rad=1e-4)))
    assert_standard_normal((scene.q_true - scene.q) / 1e-4)
    np.testing.assert_allclose(
        scene.T_base_sensor, sensor_frames(scene.workcell.arm, scene.q_true), atol=1e-13, rtol=0
    )
    np.testing.assert_array_equal(scene.poses[[f"q{i + 1}" for i in range(6)]].to_numpy(), scene.q)


def test_ranges_are_rounded_to_their_quantum(paper):
    """A quantum rounds each range to the nearest multiple, after the noise."""
    config = scene_config("paper", noise=noise(range_quantum_m=5e-5))
    config["sensor"]["selection"] = "even"
    steps = ranges_of(simulate(config)) / 5e-5
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    np.testing.assert_allclose(steps, paper.ranges / 5e-5, atol=0.5 + 1e-9)


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


def test_the_declared_model_does_not_touch_the_data(paper):
    """What the dataset declares as nominal changes neither poses nor scans."""
    config = scene_config("paper")
    other = simulate(config | {"initial_model": config["initial_model"] | {"length_std_m": 0.01}})
    pd.testing.assert_frame_equal(simulate(config).scans, other.scans)


def test_exact_parameters_are_the_truth_and_the_others_are_not(paper):
    """Of the declared model the named parameters equal the truth, and every other differs."""
    exact = set(paper.config["initial_model"]["exact"])
    assert len(exact) == 7
    for i, joint in enumerate(paper.dataset["robot"]["joints"]):
        for name in ("a", "d", "alpha", "theta"):
            same = joint[name] == paper.truth["parameters"][name][i]
            assert same == (f"{name}_{i + 1}" in exact)
    assert paper.dataset["sensor"]["nominal_pose"]["translation"] != paper.truth["parameters"]["t"]


def test_model_errors_have_the_declared_spread():
    """Errors of lengths and angles are independent Gaussian with their declared standard deviations."""
    draws = [draw_errors(MODEL, 6, np.random.default_rng(seed)) for seed in range(100)]
    for names, std in (
        (("a", "d", "t"), 0.002),
        (("alpha", "theta", "r"), 1.0 * DEG),
        (("beta",), 0.5 * DEG),
    ):
        assert_standard_normal([np.concatenate([draw[name] for name in names]) / std for draw in draws])


def test_an_exact_parameter_leaves_the_others_their_errors():
    """Declaring one parameter exact changes no other error."""
    free = draw_errors(MODEL, 6, np.random.default_rng(0))
    held = draw_errors(MODEL | {"exact": ["a_2", "sensor_rz"]}, 6, np.random.default_rng(0))
    assert held["a"][1] == 0.0 and held["r"][2] == 0.0
    free["a"][1] = free["r"][2] = 0.0
    for name, values in free.items():
        np.testing.assert_array_equal(held[name], values)


@pytest.mark.parametrize("seed", range(5))
def test_plane_guesses_are_off_by_what_was_declared(paper, seed):
    """A guess is tilted by exactly the declared angle and off by exactly the declared distance."""
    block = {"offset_m": 0.1, "offset_std_m": 0.0, "tilt_deg": 30.0, "tilt_std_deg": 0.0}
    for target_plane in paper.workcell.target_planes:
        guess = guess_plane(target_plane, block, np.random.default_rng(seed))
        normal = np.array(guess["normal"])
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-14)
        assert np.arccos(normal @ target_plane.normal) / DEG == pytest.approx(30.0, abs=1e-9)
        assert abs(guess["distance"] - target_plane.distance) == pytest.approx(0.1, abs=1e-14)


def test_the_dataset_reads_back_and_reveals_nothing(tmp_path):
    """The folder is a valid dataset, and no number that was injected stands in any of its files."""
    config = scene_config("ur10e")
    config["true_robot_errors"] |= {"beta_std_deg": 0.1}
    scene = simulate(config)
    write_scene(scene, tmp_path)
    assert read_dataset(tmp_path / "dataset").n_poses == len(scene.q)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["dataset", "truth"]
    text = "".join(path.read_text() for path in (tmp_path / "dataset").iterdir())
    truth = json.loads((tmp_path / "truth/truth.json").read_text())
    injected = [value for values in truth["parameters"].values() for value in values]
    injected += [x for normal in truth["planes"]["normals"] for x in normal] + truth["planes"]["distances"]
    injected = [value for value in injected if value not in (0.0, 1.0)]  # a floor's normal, say
    assert len(injected) > 36
    assert not [value for value in injected if repr(abs(value))[:10] in text]
    assert "seed" not in load_yaml(tmp_path / "dataset/dataset.yaml")


def test_truth_has_the_agreed_form(paper):
    """truth.json holds the agreed keys; truth_poses the agreed columns, and the frames that SciPy gives."""
    assert set(paper.truth["parameters"]) == {"a", "alpha", "d", "theta", "beta", "t", "r"}
    assert {"robot", "planes", "effects", "noise_m", "note", "seed"} <= set(paper.truth)
    table = paper.truth_poses
    assert list(table) == ["pose", *(f"q{i + 1}" for i in range(6)), "x", "y", "z", "rx", "ry", "rz"]
    q = table[[f"q{i + 1}" for i in range(6)]].to_numpy()
    limits = paper.workcell.arm.limits
    assert stats.kstest(((q - limits[:, 0]) / np.ptp(limits, axis=1)).ravel(), "uniform").pvalue > ALPHA
    T = sensor_frames(paper.workcell.arm, q)
    np.testing.assert_allclose(table[["x", "y", "z"]].to_numpy(), T[:, :3, 3], atol=1e-12, rtol=0)
    vectors = table[["rx", "ry", "rz"]].to_numpy()
    np.testing.assert_allclose(Rotation.from_rotvec(vectors).as_matrix(), T[:, :3, :3], atol=1e-12, rtol=0)


def test_evaluation_poses_do_not_depend_on_the_seed(paper):
    """Every scene of one robot is judged on the same joint angles."""
    other = simulate(scene_config("paper", seed=99)).truth_poses
    columns = [f"q{i + 1}" for i in range(6)]
    np.testing.assert_array_equal(other[columns], paper.truth_poses[columns])


def test_a_plan_serves_its_own_workcell_only():
    """A plan is refused for another workcell, and for more poses than it holds."""
    config = scene_config("paper", poses_per_plane=3)
    plan = plan_poses(config)
    with pytest.raises(SimulationError, match="another workcell"):
        simulate(config | {"seed": 2}, plan=plan)
    with pytest.raises(SimulationError, match="fewer poses"):
        simulate(config | {"poses_per_plane": 4}, plan=plan)


def test_a_scan_that_leaves_its_target_plane_is_an_error():
    """If the joints' noise throws rays off the target plane, the pose is named, and nothing is silently dropped."""
    config = scene_config("paper", noise=noise(joint_noise_std_rad=0.3))
    with pytest.raises(
        SimulationError, match=r"pose \d+ on plane \w+: \d+ of 100 rays left the target plane"
    ):
        simulate(config)


def test_nothing_of_someone_elses_is_overwritten(tmp_path, paper):
    """A folder that is no dataset or truth of ours stays as it is."""
    (tmp_path / "truth").mkdir()
    (tmp_path / "truth" / "thesis.txt").write_text("mine")
    with pytest.raises(InvalidInput):
        write_scene(paper, tmp_path)
    assert [path.name for path in tmp_path.rglob("*")] == ["truth", "thesis.txt"]


@dataclass(frozen=True)
class _Injected(Effects):
    """Turn joint 2 by 1 mrad, shift the sensor by 1 mm from half-way on, lift the target planes by 2 mm at last."""

    def joint_errors(self, world, q, poses):
        return np.tile([0, 1e-3, 0, 0, 0, 0], (len(q), 1))

    def arms(self, arm, poses, evaluating):
        half = 0 if evaluating else len(poses) // 2
        return [(slice(0, half), arm), (slice(half, None), arm.shifted({"t": np.array([1e-3, 0, 0])}))]

    def target_planes(self, target_planes, poses):
        lifted = tuple(
            replace(
                target_plane,
                centre=target_plane.centre + 2e-3 * target_plane.normal,
                distance=target_plane.distance + 2e-3,
            )
            for target_plane in target_planes
        )
        last = np.arange(len(poses)) >= len(poses) - 5
        return [(~last, target_planes), (last, lifted)]


def test_effects_act_where_they_are_injected(paper):
    """Hooks on joints, arm and target planes reach scans and evaluation poses, and do not change which poses."""
    config = scene_config("paper", noise={})
    config["sensor"]["selection"] = "even"
    scene = simulate(config, effects=_Injected())
    np.testing.assert_array_equal(scene.q, paper.q)
    arm, n = scene.workcell.arm, len(scene.q)
    dq = np.array([0, 1e-3, 0, 0, 0, 0])
    turned = scene.q + dq
    slipped = arm.shifted({"t": np.array([1e-3, 0, 0])})
    T = np.concatenate([sensor_frames(arm, turned[: n // 2]), sensor_frames(slipped, turned[n // 2 :])])
    np.testing.assert_allclose(scene.T_base_sensor, T, atol=1e-13, rtol=0)
    for k in range(n):
        target_plane = scene.workcell.target_planes[scene.plane_index[k]]
        lift = 2e-3 if k >= n - 5 else 0.0
        expected, _, _ = fan_hits(T[k], scene.angles[k], target_plane.normal, target_plane.distance + lift)
        np.testing.assert_allclose(scene.ranges[k], expected, atol=1e-13, rtol=0)
    q = scene.truth_poses[[f"q{i + 1}" for i in range(6)]].to_numpy() + dq
    np.testing.assert_allclose(
        scene.truth_poses[["x", "y", "z"]], sensor_frames(slipped, q)[:, :3, 3], atol=1e-12, rtol=0
    )


def test_progress_is_told(paper):
    """The callback hears of every stage, and each stage ends at its full count."""
    heard = {}
    simulate(
        scene_config("paper", poses_per_plane=2), progress=lambda *news: heard.update({news[0]: news[1:]})
    )
    assert heard == {"poses floor": (2, 2), "poses wall_x": (2, 2), "poses wall_y": (2, 2), "scans": (6, 6)}


def test_a_picture_shows_arm_and_laser(paper):
    """The picture has the asked size, the laser's red in it, and more than one other colour."""
    picture = render_scene(paper, 0, width=320, height=240, views=1).image
    assert picture.shape == (240, 320, 3) and picture.dtype == np.uint8
    red = picture[..., 0].astype(int) - picture[..., 1] > 60
    assert 5 < red.sum() < picture[..., 0].size / 4
    white = (picture == 255).all(2)  # the background
    assert white.mean() < 0.5  # most of the picture is target planes and arm
