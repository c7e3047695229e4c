"""Versions of the calibration's format: version 1 is still read, and what a later release adds is refused by name."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from scalar.errors import InvalidInput
from scalar.estimation.result import load_calibration
from scalar.geometry.se3 import transform_from_rotation_vector

VERSION_1 = Path(__file__).parents[1] / "version_1"
"""A calibration of a simulated dataset, and frames that the release before version 2 predicted with it."""


def test_version_1_predicts_what_it_predicted() -> None:
    """A calibration of version 1 predicts the frames that the release predicted which wrote it, to the digits of their table."""
    calibration = load_calibration(VERSION_1 / "calibration.json")
    frames = pd.read_csv(VERSION_1 / "frames.csv")
    expected = [
        transform_from_rotation_vector(row[["x", "y", "z"]], row[["rx", "ry", "rz"]])
        for _, row in frames.iterrows()
    ]
    found = calibration.predict(pd.read_csv(VERSION_1 / "joints.csv"))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11)


def test_version_1_becomes_version_2_without_loss(tmp_path: Path) -> None:
    """If it is saved again it has version 2, with the same parameters, effects and covariance."""
    load_calibration(VERSION_1 / "calibration.json").save(tmp_path / "c.json")
    old = json.loads((VERSION_1 / "calibration.json").read_text(encoding="utf-8"))
    new = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))
    assert new["format"] == "scalar-calibration/2"
    assert (new["names"], new["covariance"]) == (old["covariance"]["names"], old["covariance"]["matrix"])
    for key in ("effects", "gauge", "planes", "residual_rms_m", "summary"):
        assert new[key] == old[key]
    for name, entry in old["parameters"].items():
        assert new["parameters"][name]["value"] == pytest.approx(entry["value"], rel=1e-14, abs=1e-15)
        assert new["parameters"][name]["std"] == entry["std"]


def add_history(content: dict[str, Any]) -> None:
    """Add a key to the file."""
    content["history"] = [{"name": "pose_jitter"}]


def add_rank(content: dict[str, Any]) -> None:
    """Add a key to a parameter."""
    content["parameters"]["a_2"]["rank"] = 1


@pytest.mark.parametrize(("add", "key"), [(add_history, "history"), (add_rank, "parameters.a_2.rank")])
def test_what_a_later_release_adds_is_refused_by_name(tmp_path: Path, add: Any, key: str) -> None:
    """A key that this release does not act upon is refused by its name, not ignored."""
    load_calibration(VERSION_1 / "calibration.json").save(tmp_path / "c.json")
    content = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))
    add(content)
    (tmp_path / "c.json").write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(InvalidInput, match="not known to this release") as refused:
        load_calibration(tmp_path / "c.json")
    assert [fault.column for fault in refused.value.faults] == [key]
