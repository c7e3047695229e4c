"""``scalar plan --near``: which calibrations it takes."""

from dataclasses import replace

from click.testing import CliRunner

from scalar import calibrate, read_dataset
from scalar.cli import cli
from tests.random_scene import make_scene


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
