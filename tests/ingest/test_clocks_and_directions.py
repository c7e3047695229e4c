"""A mapping joins each point to its own pose, whatever the clocks say, and each direction to its joint."""

import numpy as np
import pandas as pd
import pytest

from tests.ingest.foreign_tables import imported, joints, refused, run, write_table
from tests.ingest.two_tables import XYZ, angles, places, two_tables
from tests.small_datasets import description


def test_a_direction_of_approach_counts_as_its_joint_does(tmp_path):
    """Whoever turns the sign of a joint is told that its direction of approach and torque stay as they are, until the mapping states their signs."""
    mapping = two_tables(tmp_path)
    columns = mapping["poses"]["columns"]
    further = [f"{name}{i}" for name in ("approach", "tau") for i in range(1, 7)]
    columns |= {name: {"column": name} for name in further}
    columns["temperature"] = {"column": "T"}
    texts = [[str(k + 1), *map(str, row), *["1"] * 12, "20"] for k, row in enumerate(angles())]
    names = ["Nr", *(f"J{i}" for i in range(1, 7)), *further, "T"]
    write_table(tmp_path / "robot.csv", texts, names, ",")
    result = run(tmp_path, mapping, tmp_path)
    assert result.exit_code == 0 and "keep the sign" not in result.output, result.output
    columns["q5"]["sign"] = -1
    assert "approach5 and tau5 keep the sign" in run(tmp_path, mapping, tmp_path).output
    columns["tau5"]["sign"] = 1
    columns["approach5"]["sign"] = -1
    output = run(tmp_path, mapping, tmp_path).output
    assert "keep the sign" not in output
    written = pd.read_csv(tmp_path / "out/poses.csv")
    assert (
        set(written["approach5"]) == {-1} and set(written["approach4"]) == {1} and set(written["tau5"]) == {1}
    )
    columns["temperature"]["sign"] = -1
    assert "only joints" in run(tmp_path, mapping, tmp_path).output


def timed_campaign(folder, slow=0.0):
    """Write tables of 40 poses, whose moves take 28 to 45 s, and of their points, 2 s later by a clock that is slow; return their mapping."""
    rng = np.random.default_rng(3)
    rows = [[f"{k}", *map(str, row)] for k, row in enumerate(np.round(rng.uniform(-2, 2, (40, 6)), 4))]
    seconds = np.cumsum(rng.uniform(28.0, 45.0, 40))
    poses = [[*row, f"{second:.3f}"] for row, second in zip(rows, seconds, strict=True)]
    write_table(folder / "robot.csv", poses, ["Nr", *(f"J{i}" for i in range(1, 7)), "Clock"], ",")
    seen = np.round(rng.uniform(500, 3000, (40, 3)), 3)
    points = [[f"{second + 2 - slow:.3f}", *map(str, row)] for second, row in zip(seconds, seen, strict=True)]
    write_table(folder / "tracker.csv", points, ["Nr", "x", "y", "z"], ",")
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {"files": [{"name": "robot.csv"}], "columns": {"pose": {"column": "Nr"}, **joints()}},
        "points": {"files": [{"name": "tracker.csv"}], "columns": dict(XYZ)},
        "dataset": description("tracker"),
    }
    mapping["poses"]["columns"]["time"] = {"column": "Clock"}
    mapping["points"] |= {"nearest_time": {"column": "Nr", "within": 13.0}, "matched_only": True}
    return mapping


@pytest.mark.parametrize("slow", [-30.0, 22.0, 33.0])
def test_a_clock_that_is_wrong_by_about_a_move_is_refused_with_its_correction(tmp_path, slow):
    """Points would be joined to the pose before or after their own, since many lie near enough; with the correction that is named they are not."""
    mapping = timed_campaign(tmp_path, slow)
    result = run(tmp_path, mapping, tmp_path)
    refused(tmp_path, result, "tracker.csv", "other poses than those at which they were measured")
    named = result.output.split("points.nearest_time.add is ")[1].split(". Look")[0]
    assert float(named) == pytest.approx(slow - 2.0, abs=12.0)
    mapping["points"]["nearest_time"]["add"] = float(named)
    np.testing.assert_array_equal(imported(tmp_path, mapping, tmp_path).pose_ids, np.arange(40))


@pytest.mark.parametrize("slow", [-2.0, 2.0, 4.0])
def test_a_clock_that_is_wrong_by_less_than_joins_another_pose_is_accepted(tmp_path, slow):
    """A delay between pose and measurement is no error."""
    mapping = timed_campaign(tmp_path, slow)
    np.testing.assert_array_equal(imported(tmp_path, mapping, tmp_path).pose_ids, np.arange(40))


def test_a_row_that_stands_in_two_files_is_named_with_both(tmp_path):
    """Of a file that was copied, each line names the copy, and the row and the file in which its entry stands already."""
    mapping = two_tables(tmp_path)
    points = [["1", "SMR1", *map(str, row)] for row in places()[:1]]
    write_table(tmp_path / "tracker.csv", points, ["Nr", "Refl", "x", "y", "z"], ",")
    write_table(tmp_path / "tracker_copy.csv", points * 40, ["Nr", "Refl", "x", "y", "z"], ",")
    mapping["points"]["files"].append({"name": "tracker_copy.csv"})
    mapping["points"]["columns"]["target"] = {"column": "Refl"}
    mapping["points"]["matched_only"] = True
    output = run(tmp_path, mapping, tmp_path).output
    assert "stands already in tracker.csv, row 2" in output
    assert "tracker.csv, column" not in output


def test_the_import_says_with_which_option_the_angles_of_the_controller_are_used(tmp_path):
    """The sentence on converted joints names the mapping as the other commands take it; without converted joints there is no such sentence."""
    mapping = two_tables(tmp_path)
    assert "--mapping" not in run(tmp_path, mapping, tmp_path).output
    mapping["poses"]["columns"]["q3"]["plus"] = "J2"
    output = run(tmp_path, mapping, tmp_path).output
    assert "q3 = J3 + J2" in output and "--mapping mapping.yaml" in output
