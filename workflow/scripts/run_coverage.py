"""Simulate and calibrate some workcells, and count which predicted poses hold the true ones."""

from job import logged

with logged(snakemake.log):
    from study.blind_trials.stratified_design import numbers_of
    from study.common.tables import write_table
    from study.coverage.design import load_coverage
    from study.coverage.run import run_workcells

    design = load_coverage(snakemake.params.config)
    write_table(snakemake.output[0], run_workcells(design, numbers_of(snakemake.wildcards.numbers)))
