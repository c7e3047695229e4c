"""Inject and diagnose some sets of the stratified blind trials."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from study.blind_trials.stratified_design import load_design, numbers_of
    from study.blind_trials.stratified_run import run_trials
    from study.common.tables import write_table

    design, numbers = load_design(snakemake.params.config), numbers_of(snakemake.wildcards.numbers)
    write_table(snakemake.output[0], run_trials(design, numbers, Path(snakemake.params.root)))
