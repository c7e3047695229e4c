"""A kind of sensor that is defined here, outside the package: its datasets are read, calibrated and diagnosed."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import Dataset, read_dataset, validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.sensor_formats import MeasuredTable, SensorFormat
from scalar.diagnosis import diagnose
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import load_calibration
from scalar.geometry.se3 import skew
from scalar.report import render_report
from scalar.sensors import FixedTarget, PointByPoint, register, stated_sigma, unregister
from tests.random_scene import make_scene
from tests.workcell import Scene

REFLECTOR = [0.9, 0.2, 0.6]  # m, base frame


@dataclass(frozen=True, eq=False)
class StereoHead(PointByPoint):
    """Measures, in its own frame, one reflector at a known position: ``h = R^T (p - o)``, so ``dh = R^T (p x w - v)``."""

    values: np.ndarray
    reflector: np.ndarray
    target_index: np.ndarray
    sigma: float
    sigma_stated: bool

    format = SensorFormat(
        "stereo-head",
        on_planes=False,
        needs_nominal_pose=True,
        table=MeasuredTable("stereo", {"x": "m", "y": "m", "z": "m"}, False, "row", largest=20.0),
        options={"reflector": {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}}},
    )
    words = "stereo head"
    observes_orientation = True

    @classmethod
    def of(cls, dataset: Dataset, extra_basis: Any = ()) -> "StereoHead":
        noise, at = dataset.sensor.noise, np.array(dataset.sensor.options["reflector"], dtype=float)
        index = np.zeros(dataset.n_poses, dtype=int)
        return cls(dataset.points, at, index, stated_sigma(noise), noise is not None)

    def initial_target(self, dataset: Dataset) -> FixedTarget:
        return FixedTarget.at([self.reflector])

    def fitted_target(self, T_base_sensor: np.ndarray, target: Any) -> FixedTarget:
        return target

    def predicted(self, T_base_sensor, target, index):
        R_T, o, p = np.swapaxes(T_base_sensor[:, :3, :3], 1, 2), T_base_sensor[:, :3, 3], target.points[index]
        wrench = np.concatenate([R_T @ skew(p), -R_T], axis=2)
        return np.einsum("nij,nj->ni", R_T, p - o), wrench, np.zeros((len(p), 3, 0))

    @classmethod
    def target_to_mapping(cls, target: Any, std: Mapping[str, float]) -> dict[str, Any]:
        return {"target": target.points.tolist()}

    @classmethod
    def target_from_mapping(cls, mapping: Mapping[str, Any]) -> FixedTarget:
        return FixedTarget.at(mapping["target"])


@pytest.fixture
def registered() -> Iterator[None]:
    """Make the kind known for one test."""
    register(StereoHead)
    yield
    unregister(StereoHead)


def scene_with_stereo_head(noise: float) -> tuple[Scene, Dataset]:
    """Return a scene, and the dataset that the stereo head measures in it."""
    scene = make_scene(kind="tracker", poses_per_plane=40, noise=0.0, stated_noise=1e-5, seed=3)
    points = in_head(scene.truth.sensor(scene.dataset.q))
    points = points + np.random.default_rng(1).normal(0.0, noise, points.shape)
    sensor = replace(scene.dataset.sensor, kind="stereo-head", options={"reflector": REFLECTOR})
    return scene, replace(scene.dataset, sensor=sensor, points=points)


def in_head(T_base_sensor: np.ndarray) -> np.ndarray:
    """Return the reflector in the frame of the head ``(N, 3)`` [m], by a formula other than that of the class."""
    return (np.linalg.inv(T_base_sensor) @ np.array([*REFLECTOR, 1.0]))[:, :3]


def write(dataset: Dataset, scene: Scene, folder):
    """Write the dataset folder as a user of the stereo head would."""
    mapping = scene.mapping()
    mapping["sensor"] |= {"kind": "stereo-head", "reflector": REFLECTOR}
    rows = pd.DataFrame({"pose": dataset.pose_ids, **dict(zip("xyz", dataset.points.T, strict=True))})
    write_dataset(folder, mapping=mapping, poses=dataset.poses, stereo=rows)
    return folder


def test_noise_free_data_give_the_truth(registered, tmp_path):
    """After reading, calibrating, saving and loading, poses that were not measured are predicted to a tenth of a micrometre."""
    scene, dataset = scene_with_stereo_head(noise=0.0)
    read = read_dataset(write(dataset, scene, tmp_path / "d"))
    np.testing.assert_array_equal(read.points, dataset.points)
    calibrate(read).save(tmp_path / "calibration.json")
    poses = scene.truth.poses(200, np.random.default_rng(2))
    q = poses[[f"q{i + 1}" for i in range(read.robot.n_joints)]].to_numpy()
    found = in_head(load_calibration(tmp_path / "calibration.json").predict(poses))
    np.testing.assert_allclose(found, in_head(scene.truth.sensor(q)), atol=1e-7)


def test_noise_alone_gives_no_effect(registered):
    """The diagnosis of a dataset whose noise is as stated finds no effect."""
    assert diagnose(scene_with_stereo_head(noise=1e-5)[1]).to_mapping()["verdict"] == "no_effect"


def test_a_kind_that_is_not_known_is_named(tmp_path):
    """If the package that defines the kind is absent, readers of datasets and calibrations name the unknown kind."""
    scene, dataset = scene_with_stereo_head(noise=0.0)
    folder = tmp_path / "d"
    register(StereoHead)
    try:
        write(dataset, scene, folder)
        calibrate(dataset).save(tmp_path / "calibration.json")
    finally:
        unregister(StereoHead)
    assert any("stereo-head" in str(fault) for fault in validate_dataset(folder))
    with pytest.raises(InvalidInput, match="stereo-head"):
        load_calibration(tmp_path / "calibration.json")


def test_its_report_uses_its_name(registered):
    """The report of a diagnosis uses the name of the kind, has a chart, and does not mention line lasers or scanners."""
    page = render_report(diagnose(scene_with_stereo_head(noise=1e-5)[1]))
    assert page.startswith("<!doctype html>") or page.startswith("<!DOCTYPE html>")
    assert StereoHead.words in page and "<svg" in page
    assert "line laser" not in page and "scanner" not in page
