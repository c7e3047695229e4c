"""The example of the Python interface in docs/api.md runs as it stands, on arrays."""

import re
from pathlib import Path

import numpy as np
import pytest

import scalar
from tests.random_scene import make_scene

PAGE = Path(__file__).parents[2] / "docs/api.md"


@pytest.fixture(scope="module")
def arrays():
    """Return joint angles, scans and names of planes as a program would hold them."""
    dataset = make_scene(seed=1, poses_per_plane=20, points_per_scan=12).dataset
    scans = np.split(dataset.points, dataset.starts[1:-1])
    return {"q": dataset.q, "points": scans, "plane": list(dataset.poses["plane"])}


def code() -> str:
    """Return the block of the page that uses arrays."""
    return next(
        block
        for block in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.S)
        if "from_arrays" in block
    )


def test_the_example_runs(arrays):
    """Its names are those of the package, its residual is the noise of the scanner, and its corrections are those of an arm that errs by degrees."""
    names = dict(arrays)
    exec(code(), names)
    assert names["rigid"].residual_rms == pytest.approx(1e-4, rel=0.3)
    assert names["diagnosis"].verdict == "no_effect"
    assert np.isfinite(names["q_to_command"]).all()


def test_lists_of_numbers_are_arrays(arrays):
    """Normals as lists give the calibration that arrays give, of any length, and a scanner needs no place on the flange."""
    robot = make_scene(seed=1, poses_per_plane=1).dataset.robot
    residuals = []
    for make in (list, np.array):
        planes = [
            scalar.PlaneGuess(f, make(n), d)
            for f, n, d in zip(
                ("floor", "wall_x", "wall_y"), 2.0 * np.eye(3)[[2, 0, 1]], (0.0, 1.2, 1.2), strict=True
            )
        ]
        dataset = scalar.Dataset.from_arrays(
            robot=robot, sensor=scalar.Sensor("line-laser"), planes=planes, **arrays
        )
        residuals.append(scalar.calibrate(dataset).residual_rms)
    assert residuals[0] == residuals[1] == pytest.approx(1e-4, rel=0.3)
