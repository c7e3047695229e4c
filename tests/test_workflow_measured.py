"""The workflow on measured robots, whose data are not in the repository: what it does with none of the files, and with some."""

import pytest

from tests.checkouts import RESULTS, SMOKE, copy_checkout, jobs, snakemake

NO_NETWORK = 'addresses: ["http://127.0.0.1:9/{path}"]'


@pytest.mark.slow
def test_measured_robots_without_data_are_left_out_with_a_message(tmp_path):
    """Without folder and network the workflow says which files are missing and what to do, and nothing fails."""
    folder = copy_checkout(tmp_path)
    for dry in (["--dry-run"], []):
        ran = snakemake(folder, "measured", *dry, *SMOKE, "--config", f"measured={{{NO_NETWORK}}}")
        assert ran.returncode == 0, ran.stdout
        assert "Traceback" not in ran.stdout
        for words in ("measurements_random_poses.csv", "no_leica_wall_table2", "measured={folder: PATH}"):
            assert words in ran.stdout
        assert set(jobs(ran.stdout)) <= {"measured"}
    assert not (folder / RESULTS / "measured").exists()


@pytest.mark.slow
def test_measured_robots_with_a_folder_run_as_far_as_their_files_go(tmp_path):
    """Sets whose files are there are planned, the transfer included, and the others are named; a file with other content is refused."""
    folder, data = copy_checkout(tmp_path / "checkout"), tmp_path / "data"
    data.mkdir()
    (data / "measurements_random_poses.csv").write_text("not these")
    (data / "measurements_iso_cubes.csv").write_text("not these")
    config = f"measured={{folder: {data}, {NO_NETWORK}}}"
    ran = snakemake(folder, "measured", "--dry-run", *SMOKE, "--config", config)
    assert ran.returncode == 0, ran.stdout
    started = jobs(ran.stdout)
    assert started["get_originals"] == started["import_measured"] == started["diagnose_measured"] == 2
    assert started["transfer_measured"] == started["summarise_measured"] == 1
    assert "no_leica_wall_table2" in ran.stdout
    ran = snakemake(folder, "measured", "--until", "get_originals", *SMOKE, "--config", config)
    assert ran.returncode != 0
    assert "not the file that was published" in ran.stdout
    assert not list((folder / RESULTS / "measured").rglob("*.csv"))
