"""``scalar plan --near`` and ``--after``: which calibrations and diagnoses they take."""

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

from scalar import calibrate, read_dataset
from scalar.cli import cli
from scalar.effects.range_scale import RangeScale
from scalar.estimation.result import Calibration
from tests.cli.running import refused, run
from tests.random_scene import make_scene


def test_the_sensor_s_place_is_taken_from_the_calibration(tmp_path):
    """A dataset.yaml without nominal_pose is planned for near its calibration; without one, the message names both ways."""
    scene = make_scene(seed=4, poses_per_plane=12, points_per_scan=10)
    bare = replace(scene.dataset, sensor=replace(scene.dataset.sensor, T_flange_sensor=None))
    folder = replace(scene, dataset=bare).write(tmp_path / "cell")
    calibrate(read_dataset(folder)).save(tmp_path / "calibration.json")
    given = ("--poses", 30, "--candidates", 100, "--no-collisions", "-o", tmp_path / "plan")
    refused(run("plan", folder, *given), 2, "sensor.nominal_pose", "--near a calibration")
    assert run("plan", folder, "--near", tmp_path / "calibration.json", *given).exit_code == 0


def test_a_calibration_of_another_arm_is_refused(tmp_path):
    """The arm that was calibrated has to be the one that is planned for; a table with rounded numbers is still that of the same arm."""
    folder = make_scene(seed=4, poses_per_plane=12, points_per_scan=10).write(tmp_path / "cell")
    calibration = calibrate(read_dataset(folder))
    nominal = calibration.model.nominal
    for step, status in ((4e-4, 0), (2e-3, 2)):
        other = nominal.with_geometry(nominal.geometry + step)
        near = tmp_path / f"calibration-{status}.json"
        replace(calibration, model=replace(calibration.model, nominal=other)).save(near)
        given = ("--poses", 3, "--candidates", 100, "--no-collisions", "-o", tmp_path / f"plan-{status}")
        result = CliRunner().invoke(cli, ["plan", str(folder), "--near", str(near), *map(str, given)])
        assert result.exit_code == status, result.output
        assert status == 0 or "it calibrates another arm: nominal" in result.stderr


@pytest.mark.parametrize(
    ("kind", "poses_per_plane", "renamed", "words"),
    [
        ("tracker", 12, {}, "its sensor is a line-laser, and that of 'vs060-tracker-4' is a tracker"),
        (
            "line-laser",
            12,
            {"floor": "table"},
            "it measured the plane 'floor', which 'vs060-line-laser-4' does not have",
        ),
        ("line-laser", 10, {}, "it was made from"),
    ],
)
def test_the_diagnosis_of_another_dataset_is_refused(tmp_path, kind, poses_per_plane, renamed, words):
    """A diagnosis goes with the folder that was diagnosed: one of another sensor, of other planes or of more poses is refused by name."""
    other = make_scene("vs060", kind, seed=4, poses_per_plane=poses_per_plane, points_per_scan=10)
    diagnosed = make_scene(seed=4, poses_per_plane=12, points_per_scan=10).dataset
    after = Calibration.nominal(replace(diagnosed, robot=other.dataset.robot))
    model = replace(after.model, effects=(RangeScale(),))
    after = replace(after, model=model, summary={"poses": diagnosed.n_poses})
    after.save(tmp_path / "after.json")
    content = {"format": "scalar-diagnosis/2", "effects": [], "unobservable": []}
    (tmp_path / "diagnosis.json").write_text(json.dumps(content), encoding="utf-8")
    folder = other.write(tmp_path / "cell")
    for name in ("dataset.yaml", "poses.csv"):
        text = (folder / name).read_text(encoding="utf-8")
        for old, new in renamed.items():
            text = text.replace(old, new)
        (folder / name).write_text(text, encoding="utf-8")
    given = ("--candidates", 100, "--no-collisions", "-o", tmp_path / "plan")
    result = run("plan", folder, "--after", tmp_path / "diagnosis.json", *given)
    refused(
        result,
        2,
        "diagnosis.json: the diagnosis of another dataset",
        words,
        output=tmp_path / "plan",
        lines=1,
    )
