"""The mapping that `scalar import --example` prints reads tables in degrees and millimetres as it is."""

import numpy as np
import pandas as pd
import pytest
import yaml

from scalar.data.dataset import read_dataset
from scalar.units import DEG, MM
from tests.cli.running import run
from tests.random_scene import make_scene

KINDS = {"tracker": ["points"], "line-laser": ["scans"], "probe": []}


def printed(folder):
    """Return the text of the mapping for a folder."""
    result = run("import", "--example", folder)
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.mark.parametrize("kind", KINDS)
def test_the_printed_mapping_reads_tables_in_degrees_and_millimetres(kind, tmp_path):
    """Tables whose columns are called as in the mapping, in its units, give the dataset back."""
    made = make_scene("vs060", kind, seed=3, poses_per_plane=5).dataset
    made.write(tmp_path / "cell")
    (tmp_path / "mapping.yaml").write_text(printed(tmp_path / "cell"), encoding="utf-8")
    mapping = yaml.safe_load(printed(tmp_path / "cell"))
    sizes = {"deg": DEG, "mm": MM}
    sources = tmp_path / "sources"
    sources.mkdir()
    for block, written, read in (
        ("poses", "robot", "poses"),
        *(("points", stem, stem) for stem in KINDS[kind]),
    ):
        table = pd.read_csv(tmp_path / "cell" / f"{read}.csv")
        columns = mapping[block]["columns"]
        foreign = {
            rule["column"]: table[name] / sizes[rule["unit"]] if "unit" in rule else table[name]
            for name, rule in columns.items()
        }
        pd.DataFrame(foreign).to_csv(sources / f"{written}.csv", index=False)
    result = run("import", tmp_path / "mapping.yaml", *sorted(sources.iterdir()), "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    back = read_dataset(tmp_path / "out")
    assert np.allclose(back.q, made.q, rtol=0, atol=1e-12)
    assert np.allclose(back.points, made.points, rtol=0, atol=1e-12)
    assert np.array_equal(back.plane_index, made.plane_index)


def test_a_controller_that_shows_a_joint_otherwise_is_converted(tmp_path):
    """The library says that joint 3 of a FANUC is J3 + J2; the mapping of any other maker's arm adds nothing."""
    for arm, added in (("fanuc_m20ia", {"q3": "J2"}), ("kuka_kr6_r900_sixx", {})):
        assert run("init", tmp_path / arm, "--robot", arm, "--sensor", "tracker").exit_code == 0
        columns = yaml.safe_load(printed(tmp_path / arm))["poses"]["columns"]
        assert {name: rule["plus"] for name, rule in columns.items() if "plus" in rule} == added


def test_a_travel_is_in_millimetres(tmp_path):
    """A joint that slides has lengths."""
    table = tmp_path / "rail.csv"
    table.write_text("a_mm,alpha_deg,d_mm,theta_deg,type\n0,0,0,0,prismatic\n0,90,400,0,revolute\n")
    begun = ("init", tmp_path / "rail", "--dh", table, "--convention", "modified-dh", "--sensor", "tracker")
    assert run(*begun).exit_code == 0
    columns = yaml.safe_load(printed(tmp_path / "rail"))["poses"]["columns"]
    assert [columns[name]["unit"] for name in ("q1", "q2")] == ["mm", "deg"]


def test_a_folder_without_a_description_is_refused(tmp_path):
    """So is one whose description names no sensor; nothing is printed to be taken for a mapping."""
    (tmp_path / "other").mkdir()
    for text in (None, "format: scalar-dataset/2\n"):
        if text:
            (tmp_path / "other" / "dataset.yaml").write_text(text)
        result = run("import", "--example", tmp_path / "other")
        assert result.exit_code == 2 and not result.stdout and "dataset.yaml" in result.stderr


@pytest.mark.parametrize(("sensor", "said"), [("line-laser", True), ("tracker", False), ("probe", False)])
def test_the_readme_names_the_mapping_and_says_where_a_scanner_measures_to(sensor, said, tmp_path):
    """Only a scanner has columns x and z of its own plane."""
    assert run("init", tmp_path / "cell", "--robot", "ur5e", "--sensor", sensor).exit_code == 0
    readme = (tmp_path / "cell" / "README.txt").read_text()
    assert ("z points from the scanner" in readme) == said and "import --example" in readme


def test_a_plane_that_is_called_otherwise_is_refused_with_how_a_mapping_translates_it(tmp_path):
    """A table of the robot often numbers the planes; in a dataset itself nothing is said of mappings."""
    made = make_scene("vs060", "probe", seed=3, poses_per_plane=5).dataset
    made.write(tmp_path / "cell")
    mapping = printed(tmp_path / "cell").replace("  files: [{name: robot.csv}]\n", "")
    (tmp_path / "mapping.yaml").write_text(mapping, encoding="utf-8")
    table = pd.read_csv(tmp_path / "cell" / "poses.csv").rename(
        columns={f"q{i}": f"J{i}" for i in range(1, 7)}
    )
    table.assign(plane="Surface 1").to_csv(tmp_path / "robot.csv", index=False)
    result = run("import", tmp_path / "mapping.yaml", tmp_path / "robot.csv", "-o", tmp_path / "out")
    assert result.exit_code == 2 and "names of this column in the mapping: names:" in result.output
    table = pd.read_csv(tmp_path / "cell" / "poses.csv").assign(plane="Surface 1")
    table.to_csv(tmp_path / "cell" / "poses.csv", index=False)
    result = run("validate", tmp_path / "cell")
    assert result.exit_code == 2 and "unknown plane" in result.output and "mapping" not in result.output
