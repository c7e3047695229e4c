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


def code(page: Path = PAGE, word: str = "from_arrays") -> str:
    """Return the block of a page that has a word: that which uses arrays, of the page on the Python interface."""
    return next(
        block for block in re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.S) if word in block
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


def test_lists_of_controllers_have_the_corrected_angles(tmp_path, monkeypatch, capsys):
    """The block on programs writes one target in KRL and one in RAPID for each row, with the angles of the table."""
    rows = "pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,corrected\n7,1.5,-20,30.25,0,5,-6,1\n9,1,2,3,4,5,6,1\n"
    (tmp_path / "corrected.csv").write_text(rows)
    monkeypatch.chdir(tmp_path)
    exec(code(PAGE.parent / "own_robot.md", "jointtarget"), {})
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    assert lines[0] == "DECL E6AXIS XP7={A1 1.5000,A2 -20.0000,A3 30.2500,A4 0.0000,A5 5.0000,A6 -6.0000}"
    assert (
        lines[3]
        == "CONST jointtarget p9:=[[1.0000,2.0000,3.0000,4.0000,5.0000,6.0000],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    )
