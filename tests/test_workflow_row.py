"""A row more in a grid, run: a case of its own in tables and figures, and the first case as it was."""

import pandas as pd
import pytest

from tests.checkouts import copy_checkout, jobs, snakemake

CONFIG = """
results: results
first_seed: 1
seeds_per_job: 1
studies:
  headline: {scene: configs/scenes/paper.yaml, grid: configs/grids/smoke.csv, seeds: 1, methods: [proposed]}
"""
FIRST, NEW = "results/headline/figures/errors.png", "results/headline/figures/errors_more.png"
ROW = "more,20,20,300\n"


@pytest.mark.slow
def test_another_row_has_its_own_figures_and_does_not_change_the_first_case(tmp_path):
    """The new case has its own figure and errors; the first case has the same figure with the row or without, byte by byte."""
    folder = copy_checkout(tmp_path)
    (folder / "small.yaml").write_text(CONFIG, encoding="utf-8")
    grid = folder / "configs/grids/smoke.csv"
    rows = grid.read_text(encoding="utf-8")
    grid.write_text(rows + ROW, encoding="utf-8")
    ran = snakemake(folder, FIRST, NEW, "--configfile", "small.yaml")
    assert ran.returncode == 0, ran.stdout
    errors = pd.read_csv(folder / "results/headline/errors.csv")
    own = {case: rows["position_mean_mm"].tolist() for case, rows in errors.groupby("case")}
    assert set(own) == {"smoke", "more"} and own["smoke"] != own["more"]
    first, new = ((folder / path).read_bytes() for path in (FIRST, NEW))
    assert first != new

    grid.write_text(rows, encoding="utf-8")
    ran = snakemake(folder, FIRST, "--configfile", "small.yaml")
    assert ran.returncode == 0, ran.stdout
    assert set(jobs(ran.stdout)) == {"collect", "draw_errors"}
    assert (folder / FIRST).read_bytes() == first
