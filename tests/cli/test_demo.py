"""`scalar demo`: the secret is told after the answer, nothing is overwritten, and without pybullet one line says what to install."""

import json
import subprocess
import sys

import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.cli.demo import reveal

WITHOUT_PYBULLET = """
import sys
sys.modules["pybullet"] = None
from scalar.cli import main
sys.argv[0] = "scalar"
main()
"""


@pytest.mark.slow
def test_the_demo_writes_a_report_and_then_tells_the_secret(tmp_path):
    """Dataset, truth and report are written.

    No file of the dataset contains the secret, the last lines tell it, and a second run is refused and changes nothing.
    """
    pytest.importorskip("pybullet")
    output = tmp_path / "demo"
    result = CliRunner().invoke(cli, ["demo", "--seed", "7", "-o", str(output)])
    assert result.exit_code == 0, result.output
    assert (output / "diagnosis" / "report.html").stat().st_size > 0
    (secret,) = json.loads((output / "truth" / "truth.json").read_text())["effects"]
    files = [path for path in (output / "dataset").rglob("*") if path.is_file()]
    assert files and all(secret["name"].encode() not in path.read_bytes() for path in files)
    lines = result.stdout.splitlines()
    assert [line.split()[0] for line in lines[:3]] == ["1", "2", "3"]
    (at,) = [i for i, line in enumerate(lines) if line.startswith("the secret was: ")]
    (report,) = [i for i, line in enumerate(lines) if line.startswith("report: ")]
    assert 3 < report < at and str(output / "diagnosis" / "report.html") in lines[report]
    before = {path: path.read_bytes() for path in output.rglob("*") if path.is_file()}
    again = CliRunner().invoke(cli, ["demo", "--seed", "7", "-o", str(output)])
    assert again.exit_code == 2 and "already there, and the demo overwrites nothing" in again.stderr
    assert {path: path.read_bytes() for path in output.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize("arguments", [("demo",), ("simulate", "scene.yaml")])
def test_without_the_simulator_one_line_says_what_to_install(arguments, tmp_path):
    """The exit status is 2, one line names the extra, and nothing is written."""
    output = tmp_path / "demo"
    command = [sys.executable, "-c", WITHOUT_PYBULLET, *arguments, "-o", str(output)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 2 and run.stdout == ""
    (line,) = run.stderr.splitlines()
    assert "pybullet" in line and "scalar-calibration[simulation]" in line
    assert not output.exists()


HARMONIC = {"name": "joint_harmonic", "target": {"joint": 3, "order": 2}, "size": 3e-4, "unit": "rad"}
SAG = {"name": "joint_compliance", "target": {"joints": [2, 3]}, "size": 1e-5, "unit": "rad/(N m)"}
SLIP = {"name": "sensor_slip", "target": {"at": {"order": 70, "time": 1.0}}, "size": 2e-3, "unit": "m"}


@pytest.mark.parametrize(
    ("secret", "found", "words"),
    [
        (HARMONIC, [("joint_harmonic", {"joint": 3, "order": 2})], "has named it"),
        (HARMONIC, [("joint_harmonic", {"joint": 3, "orders": [1, 2]})], "has named it"),
        (HARMONIC, [("joint_harmonic", {"joint": 3, "order": 1})], "another place"),
        (HARMONIC, [("joint_harmonic", {"joint": 2, "orders": [1, 2]})], "another place"),
        (HARMONIC, [("joint_scale", {"joint": 3})], "something else"),
        (HARMONIC, [], "has not named it; its verdict is `no_effect`"),
        (SAG, [("joint_compliance", {"joints": [2]})], "has named it"),
        (SAG, [("joint_compliance", {"joints": [2, 5]})], "another place"),
        (SLIP, [("joint_scale", {"joint": 1}), ("sensor_slip", {"at": {"order": 71}})], "has named it"),
    ],
)
def test_the_answer_is_judged_by_kind_and_place(secret, found, words):
    """The last line distinguishes the right answer, the right kind at another place, another kind, and no answer."""
    assert words in reveal(secret, [{"name": name, "target": target} for name, target in found], "no_effect")


@pytest.mark.parametrize(
    ("secret", "size"),
    [
        (HARMONIC, "of size 0.0172 deg;"),
        (SLIP, "of size 2 mm;"),
        (
            SAG | {"largest_deflection_rad": {"joint2": 1e-3, "joint3": 4e-4}},
            "up to 0.057 deg, with 1e-05 rad/(N m);",
        ),
        (
            {"name": "joint_scale", "target": {"joint": 1}, "size": 1e-3, "unit": "rad/rad"},
            "of size 0.001 rad/rad;",
        ),
    ],
)
def test_the_secret_is_told_in_the_units_of_the_diagnosis(secret, size):
    """Angles are in degrees, lengths in millimetres, and of a compliance the largest deflection is told."""
    assert size in reveal(secret, [], "no_effect")
