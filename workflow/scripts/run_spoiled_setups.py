"""Simulate, spoil and calibrate some set-ups."""

from job import logged

with logged(snakemake.log):
    from study.blind_trials.stratified_design import numbers_of
    from study.common.tables import write_table
    from study.spoiled_setups.design import load_spoiled
    from study.spoiled_setups.run import run_setups

    design = load_spoiled(snakemake.params.config)
    write_table(snakemake.output[0], run_setups(design, numbers_of(snakemake.wildcards.numbers)))
