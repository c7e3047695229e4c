"""A grid holds cases, each of which changes a scene, and refuses what a scene does not know."""

from pathlib import Path

import pytest
from study.common.grid import read_grid, with_overrides

from scalar.errors import InvalidInput


def grid(folder: Path, text: str) -> Path:
    path = folder / "grid.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_each_row_is_a_case_with_values_of_their_types(tmp_path):
    """Whole numbers stay whole in a column with empty cells, and 1e-4 is read as a number."""
    text = "case,scene,poses_per_plane,noise.range_noise_std_m\nfine,,40,1e-4\nbare,other.yaml,,\n"
    fine, bare = read_grid(grid(tmp_path, text))
    assert (fine.name, fine.scene) == ("fine", None)
    assert fine.overrides == {"poses_per_plane": 40, "noise.range_noise_std_m": 1e-4}
    assert isinstance(fine.overrides["poses_per_plane"], int)
    assert (bare.scene, bare.overrides) == ("other.yaml", {})


def test_overrides_reach_into_a_copy(tmp_path):
    """The given config is not changed, and blocks that it lacks are added to the copy."""
    config = {"sensor": {"rays": 640}}
    changed = with_overrides(config, {"sensor.points_per_scan": 7, "noise.scan_bias_std_m": 1e-4})
    assert changed == {"sensor": {"rays": 640, "points_per_scan": 7}, "noise": {"scan_bias_std_m": 1e-4}}
    assert config == {"sensor": {"rays": 640}}


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("case,noise.range_noise_std\na,1e-4\n", ["noise.range_noise_std", "range_noise_std_m", "row 1"]),
        ("case,poses\na,40\n", ["poses", "poses_per_plane"]),
        ("poses_per_plane\n40\n", ["case", "missing"]),
        ("case,poses_per_plane\na,40\na,50\n", ["row 3", "'a'"]),
        ("case,poses_per_plane\na,many\n", ["row 2", "poses_per_plane", "many"]),
        ("case,noise.range_noise_std_m\na,-1\n", ["row 2", "noise.range_noise_std_m"]),
        ("case,poses_per_plane\na/b,40\n", ["row 2", "a/b"]),
        ("case,poses_per_plane\na,40,50\n", ["row 2"]),
        ("case,poses_per_plane,poses_per_plane\na,40,50\n", ["poses_per_plane", "2 columns"]),
        ("case,poses_per_plane\n", ["no case"]),
        ("", ["case"]),
    ],
)
def test_what_a_scene_does_not_know_is_refused_by_name(tmp_path, text, named):
    """The message names the row, the column and the misspelt word, before anything has run."""
    with pytest.raises(InvalidInput) as caught:
        read_grid(grid(tmp_path, text))
    for word in named:
        assert word in str(caught.value)


def test_a_missing_grid_is_named(tmp_path):
    """A wrong path is reported as a fault of the input, not by a traceback."""
    with pytest.raises(InvalidInput, match=r"none\.csv"):
        read_grid(tmp_path / "none.csv")
