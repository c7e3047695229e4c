"""Each command that takes a calibration takes one with any effect: it predicts, corrects, and compares two campaigns of one arm without a change."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from scalar import calibrate
from scalar.cli import cli
from tests.effects.everything import every_effect, optional_columns
from tests.effects.injected import make_cell

CELL = make_cell(seed=3, poses_per_plane=14, points_per_scan=8, columns=optional_columns)
EFFECTS = every_effect(CELL.dataset, np.random.default_rng(0))
POSES = 8  # of the program, none of them near a singularity


def done(*arguments):
    """Return what a command prints that has to end well."""
    result = CliRunner().invoke(cli, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.parametrize("which", range(len(EFFECTS)))
def test_every_effect_is_predicted_corrected_and_compared(which, tmp_path):
    """Estimates of a second campaign that differ as the covariance says are no change of the arm, and no distance is beyond 3 mm."""
    calibration = calibrate(CELL.dataset, effects=[EFFECTS[which]])
    model = calibration.model
    calibration.save(tmp_path / "a.json")
    rng, later = np.random.default_rng(which), model.vector.copy()
    steps = np.linalg.cholesky(calibration.covariance) @ rng.standard_normal(len(calibration.free))
    later[[model.names.index(name) for name in calibration.free]] += steps
    replace(calibration, model=model.with_vector(later)).save(tmp_path / "b.json")
    program = CELL.dataset.poses.iloc[:POSES].assign(order=range(POSES))
    program.to_csv(tmp_path / "q.csv", index=False)
    done("predict", tmp_path / "a.json", tmp_path / "q.csv", "-o", tmp_path / "frames.csv", "--std")
    done("correct", tmp_path / "a.json", tmp_path / "q.csv", "-o", tmp_path / "joints.csv")
    said = done("compare", tmp_path / "a.json", tmp_path / "b.json")
    assert "no change of the arm beyond chance" in said
    (distance,) = [line for line in said.splitlines() if line.startswith("predicted positions differ by")]
    assert float(distance.split()[4]) < 3.0  # mm: 24 coefficients of the whole arm, from a part of the poses
