"""Simulate and diagnose some sets of the real-arm trials."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from study.blind_trials.stratified_design import numbers_of
    from study.common.tables import write_table
    from study.real_arm_trials.design import load_real_arm
    from study.real_arm_trials.run import run_trials

    params, wildcards = snakemake.params, snakemake.wildcards
    sets = run_trials(
        load_real_arm(params.config), wildcards.instrument, numbers_of(wildcards.numbers), Path(params.root)
    )
    write_table(snakemake.output[0], sets)
