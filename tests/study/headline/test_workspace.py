"""Correlations and the map of errors: the correlations are those of the covariance, and every pose is in one cell of each view."""

import numpy as np
import pytest
from study.headline.calibrate import calibrate_seeds
from study.headline.simulate import simulate_seeds
from study.headline.workspace import STATES, correlation, map_errors

from scalar.data.dataset import read_dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.evaluate import evaluate
from scalar.evaluate.truth import read_truth
from scalar.units import MM

SMALL = {"poses_per_plane": 14, "sensor.points_per_scan": 20, "truth_poses": 400}


@pytest.fixture(scope="module")
def batch(tmp_path_factory, request):
    """Return the folders of data and calibrations of two seeds."""
    folder = tmp_path_factory.mktemp("workspace")
    simulate_seeds(request.config.rootpath / "configs/scenes/paper.yaml", SMALL, [1, 2], folder / "data")
    calibrate_seeds(folder / "data", "proposed", folder / "calibrations")
    return folder / "data", folder / "calibrations"


def test_correlations_are_those_of_the_covariance(batch):
    """The matrix is symmetric with ones on the diagonal and no value beyond one; with the standard errors it gives the covariance."""
    calibration = calibrate(read_dataset(batch[0] / "seed-001" / "dataset"))
    table = correlation(calibration)
    matrix = table.drop(columns="parameter").to_numpy()
    assert list(table["parameter"]) == list(calibration.free) == list(table.columns[1:])
    assert np.allclose(matrix, matrix.T) and np.allclose(np.diag(matrix), 1)
    assert np.abs(matrix).max() <= 1 + 1e-9
    std = np.array(list(calibration.std.values()))
    assert np.allclose(matrix * std * std[:, None], calibration.covariance)


def test_the_map_holds_every_pose_once_a_view_and_its_mean_square(batch):
    """Cells weighted by their poses give back the root mean square error over all poses and seeds."""
    table, seeds = map_errors([batch[0]], [batch[1]])
    assert seeds == 2
    squares = dict.fromkeys(STATES, 0.0)
    for seed in ("seed-001", "seed-002"):
        dataset = read_dataset(batch[0] / seed / "dataset")
        truth_poses, truth = read_truth(batch[0] / seed / "truth", 6)
        before = evaluate(Calibration.nominal(dataset), truth_poses, truth).raw.position
        after = evaluate(calibrate(dataset), truth_poses, truth)
        for state, values in zip(
            STATES, (before, after.raw.position, after.predicted_position_std), strict=True
        ):
            squares[state] += float(np.mean((values / MM) ** 2)) / 2
    for _, rows in table.groupby("view"):
        assert rows["poses"].sum() == 400
        for state in STATES:
            assert np.average(rows[state] ** 2, weights=rows["poses"]) == pytest.approx(
                squares[state], rel=1e-6
            )
    assert set(table["view"]) == {"side", "above"}
    assert (table.loc[table["view"] == "side", "u_m"] > 0).all()
