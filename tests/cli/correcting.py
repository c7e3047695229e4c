"""Run ``scalar correct`` and ``scalar predict`` on a program of joint angles, and read the tables that they write."""

import pandas as pd
from click.testing import CliRunner

from scalar.cli import cli

WRITTEN = (
    "corrected",
    "beyond_limits",
    "near_singular",
    "smallest_singular_value",
    "position_error",
    "orientation_error",
)
"""What `scalar correct` says of each row, besides the joint angles."""
FRAME = ["x", "y", "z", "rx", "ry", "rz"]
JOINTS = [f"q{i}" for i in range(1, 7)]


def run(*arguments):
    """Return status and output of the command line."""
    result = CliRunner().invoke(cli, [str(a) for a in arguments])
    return result.exit_code, result.output


def frames(path):
    """Return the frames of a table ``(N, 6)`` [m, rad]."""
    return pd.read_csv(path)[FRAME].to_numpy()


def corrected(program, name, *options):
    """Return the table that ``scalar correct`` writes."""
    status, said = run(
        "correct", program / "calibration.json", program / name, "-o", program / "joints.csv", *options
    )
    assert status == 0, said
    return pd.read_csv(program / "joints.csv")


def predicted(program, name, *options):
    """Return the table that ``scalar predict`` writes."""
    status, said = run(
        "predict", program / "calibration.json", program / name, "-o", program / "frames.csv", *options
    )
    assert status == 0, said
    return pd.read_csv(program / "frames.csv")
