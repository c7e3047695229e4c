"""Simulate and diagnose some sets of the tracked trials."""

from job import logged

with logged(snakemake.log):
    from study.blind_trials.stratified_design import numbers_of
    from study.common.tables import write_table
    from study.tracked_trials.design import load_tracked
    from study.tracked_trials.run import run_trials

    design, wildcards = load_tracked(snakemake.params.config), snakemake.wildcards
    write_table(snakemake.output[0], run_trials(design, wildcards.sensor, numbers_of(wildcards.numbers)))
