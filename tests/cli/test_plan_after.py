"""``scalar plan --after``: poses that separate what a diagnosis leaves open, or why there are none."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.result import Calibration
from tests.cli.running import INPUT_AT_FAULT, refused, run
from tests.random_scene import make_scene


def gear_or_scale(folder, dataset, size):
    """Return a folder with a calibration that has a gear error of joint 4 [rad], and the entry of a diagnosis that takes it for that or a scale."""
    effect = JointHarmonic(4, (1,), coefficients=np.array([size, 0.0]))
    made = Calibration.nominal(dataset)
    out = folder / "out"
    out.mkdir()
    replace(made, model=replace(made.model, effects=(effect,))).save(out / "after.json")
    entry = {
        "name": effect.name,
        "target": effect.target,
        "coefficients": {"sin_rad": {"value": size}, "cos_rad": {"value": 0.0}},
        "confounded_with": [{"name": JointScale.name, "target": {"joint": 4}}],
    }
    return out, entry


def narrowed(path, joint, limits):
    """Change the limits of a joint, counted from 0, in a dataset.yaml."""
    content = load_yaml(path)
    content["robot"]["joints"][joint]["limits"] = limits
    dump_yaml(content, path)


@pytest.mark.parametrize("doubtful", [False, True])
def test_poses_that_separate_a_gear_from_a_scale(doubtful, tmp_path):
    """Poses over a small part of a joint's range do not distinguish a first harmonic from a scale, and the plan's poses do.

    The same holds if the diagnosis gives the cause no name and only says what it is most like.
    """
    scene = make_scene("vs060", "tracker", seed=2, poses_per_plane=20)
    poses = scene.dataset.poses.copy()
    poses["q4"] = np.linspace(-0.1, 0.1, len(poses))
    dataset = replace(scene.dataset, poses=poses.assign(order=np.arange(float(len(poses)))))
    replace(scene, dataset=dataset).write(tmp_path / "cell")
    out, entry = gear_or_scale(tmp_path, dataset, 1e-3)
    told = {"name": "unattributed", "target": {}, "confounded_with": [], "most_like": [entry]}
    diagnosis = {"format": "scalar-diagnosis/2", "effects": [told if doubtful else entry], "unobservable": []}
    (out / "diagnosis.json").write_text(json.dumps(diagnosis), encoding="utf-8")
    options = ("--poses", 12, "--candidates", 100, "--no-collisions")
    result = run("plan", tmp_path / "cell", "--after", out / "diagnosis.json", *options, "-o", tmp_path / "p")
    assert result.exit_code == 0, result.output
    (question,) = json.loads((tmp_path / "p" / "plan.json").read_text(encoding="utf-8"))["questions"]
    assert question["standard_errors_now"] < 2
    assert question["separated"]
    planned = pd.read_csv(tmp_path / "p" / "poses.csv")
    assert np.ptp(planned["q4"]) > 1.0
    assert planned["pose"].min() == scene.dataset.pose_ids.max() + 1
    assert planned["order"].min() > dataset.known_poses.order.max()
    assert "append" in result.output
    entry["confounded_with"] = []
    (out / "diagnosis.json").write_text(json.dumps(diagnosis), encoding="utf-8")
    result = run("plan", tmp_path / "cell", "--after", out / "diagnosis.json", "-o", tmp_path / "q", *options)
    assert result.exit_code == 0 and not (tmp_path / "q").exists()
    assert "it leaves nothing open" in result.output and f"--near {out / 'after.json'}" in result.output
    earlier = run(
        "plan", tmp_path / "cell", "--after", out / "diagnosis.json", "-o", tmp_path / "p", *options
    )
    refused(earlier, INPUT_AT_FAULT, "an earlier plan", "remove", lines=1)
    alone = tmp_path / "alone" / "diagnosis.json"
    alone.parent.mkdir()
    (out / "diagnosis.json").rename(alone)
    refused(
        run("plan", tmp_path / "cell", "--after", alone, "-o", tmp_path / "q", *options),
        INPUT_AT_FAULT,
        "name it with --near",
        lines=1,
    )


def refused_plan(folder, dataset, size):
    """Return the two lines on the terminal where a plan after a gear or a scale of this size [rad] is refused; it writes nothing.

    Args:
        folder: Holds the dataset in ``cell``. dataset: The same.
        size: Of the coefficients that the diagnosis states.
    """
    out, entry = gear_or_scale(folder, dataset, size)
    diagnosis = {"format": "scalar-diagnosis/2", "effects": [entry], "unobservable": []}
    (out / "diagnosis.json").write_text(json.dumps(diagnosis), encoding="utf-8")
    options = ("--poses", 8, "--candidates", 100, "--no-collisions")
    result = run("plan", folder / "cell", "--after", out / "diagnosis.json", *options, "-o", folder / "p")
    assert result.exit_code == 3, result.output
    assert not (folder / "p").exists()
    return result.stderr.splitlines()


def test_poses_that_would_separate_nothing_are_not_written(tmp_path):
    """If no poses distinguish a tiny gear error from a scale, the exit status is 3, the message says what may help, and nothing is written."""
    scene = make_scene("vs060", "tracker", seed=2, poses_per_plane=20)
    scene.write(tmp_path / "cell")
    first, second, third = refused_plan(tmp_path, scene.dataset, 1e-9)
    assert "no poses separate it" in first and "5 are needed" in first and "--candidates" in second
    assert "less than these measurements can show" in first and "--near" in third and "after.json" in third


def test_where_no_pose_can_show_an_effect_no_better_sensor_is_advised(tmp_path):
    """If joint 4 turns by two degrees only, its gear error looks like a scale and a zero: the message says so, and advises other measurements."""
    scene = make_scene("vs060", "tracker", seed=2, poses_per_plane=20)
    poses = scene.dataset.poses.copy()
    poses["q4"] = np.linspace(0.48, 0.52, len(poses))
    dataset = replace(scene.dataset, poses=poses)
    replace(scene, dataset=dataset).write(tmp_path / "cell")
    narrowed(tmp_path / "cell" / "dataset.yaml", 3, [0.48, 0.52])
    first, second, _ = refused_plan(tmp_path, dataset, 1e-3)
    assert (
        "a better sensor would not help" in first and "less noise" not in second and "joint limits" in second
    )
    assert "--fan" not in second and "planes" not in second  # a tracker has neither
