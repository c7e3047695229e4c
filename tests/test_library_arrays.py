"""The library on plain arrays: a probe with reference planes, and predictions with the columns that effects need, by keyword."""

from dataclasses import replace

import numpy as np
import pytest

from scalar import Calibration, Dataset, InvalidInput, calibrate, read_dataset
from scalar.effects.sensor_slip import SensorSlip
from tests.random_scene import make_scene

DISTANCE_STD, NORMAL_STD = 1e-5, 1e-4


@pytest.fixture(scope="module")
def folder_dataset():
    """Return a probe's dataset whose planes are known references."""
    data = make_scene(kind="probe", seed=4, poses_per_plane=25, noise=1e-5).dataset
    known = tuple(replace(p, distance_std=DISTANCE_STD, normal_std=NORMAL_STD) for p in data.planes)
    return replace(data, planes=known)


def from_arrays(data: Dataset) -> Dataset:
    """Return the same dataset from its arrays."""
    return Dataset.from_arrays(
        robot=data.robot,
        sensor=data.sensor,
        q=data.q,
        planes=data.planes,
        plane=list(data.poses["plane"]),
        pose_ids=data.pose_ids,
    )


def test_a_probe_with_reference_planes_from_arrays_is_the_folder(folder_dataset, tmp_path):
    """Arrays and the folder that is written from them give the same calibration, standard deviations of the planes included."""
    data = from_arrays(folder_dataset)
    data.write(tmp_path / "d")
    read = read_dataset(tmp_path / "d")
    for other in (folder_dataset, read):
        np.testing.assert_array_equal(data.q, other.q)
        np.testing.assert_array_equal(data.plane_index, other.plane_index)
        assert data.points.shape == other.points.shape == (0, 2)
        assert [p.name for p in data.planes] == [p.name for p in other.planes]
    assert {(p.distance_std, p.normal_std) for p in read.planes} == {(DISTANCE_STD, NORMAL_STD)}


def test_reference_planes_from_arrays_carry_the_scale(folder_dataset):
    """With reference planes no length of a probe's arm is fixed for the scale, and without them one is."""
    rough = tuple(replace(p, distance_std=None, normal_std=None) for p in folder_dataset.planes)
    reasons = [
        " ".join(calibrate(from_arrays(data)).fixed.values())
        for data in (folder_dataset, replace(folder_dataset, planes=rough))
    ]
    assert "may be scaled" not in reasons[0] and "may be scaled" in reasons[1]


@pytest.mark.parametrize("change", [{"plane": None}, {"points": np.zeros((75, 3))}])
def test_arrays_that_are_no_probe_are_refused(folder_dataset, change):
    """Contacts without the names of their planes, or with points, are refused by the name of the array."""
    arrays = {"plane": list(folder_dataset.poses["plane"]), "planes": folder_dataset.planes} | change
    with pytest.raises(InvalidInput, match="plane" if "plane" in change else "points"):
        Dataset.from_arrays(
            robot=folder_dataset.robot, sensor=folder_dataset.sensor, q=folder_dataset.q, **arrays
        )


def slipped(dataset: Dataset) -> Calibration:
    """Return the nominal model with a sensor that shifts by 1 mm along its x axis at order 10."""
    nominal = Calibration.nominal(dataset)
    slip = SensorSlip(order=10.0, turns=False, coefficients=np.array([1e-3, 0.0, 0.0]))
    return replace(nominal, model=replace(nominal.model, effects=(slip,)))


def test_predict_takes_columns_by_keyword(folder_dataset):
    """``order`` may be an array, one number, or absent, which means the end; predictions before and after the slip are 1 mm apart."""
    calibration = slipped(folder_dataset)
    q = folder_dataset.q[:2]
    before, after = calibration.predict(q, order=0.0), calibration.predict(q, order=[20.0, 20.0])
    np.testing.assert_array_equal(calibration.predict(q), after)
    mixed = calibration.predict(q, order=[0.0, 20.0])
    np.testing.assert_array_equal(mixed, np.stack([before[0], after[1]]))
    shift = np.linalg.norm(after[:, :3, 3] - before[:, :3, 3], axis=1)
    np.testing.assert_allclose(shift, 1e-3, rtol=1e-9)


def test_a_column_of_another_length_is_refused_by_name(folder_dataset):
    """Three orders for two poses are refused, and the message has the name of the keyword."""
    with pytest.raises(InvalidInput, match=r"order.*\(3,\).*\(2,\)"):
        slipped(folder_dataset).predict(folder_dataset.q[:2], order=[0.0, 1.0, 2.0])
