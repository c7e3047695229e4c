"""Run one case of a sweep over a batch of seeds."""

from job import logged

with logged(snakemake.log):
    from scalar.study.sweep import DIGITS, sweep_case
    from scalar.study.tables import write_table

    given, params = snakemake.input, snakemake.params
    table = sweep_case(params.case, given.scene, params.overrides, params.seeds, params.methods, given.plans)
    write_table(snakemake.output[0], table, DIGITS)
