"""Calibrate a batch of seeds at once and one after the other."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import write_table
    from study.sequential.compare import DIGITS, compare_sequential

    params = snakemake.params
    table = compare_sequential(snakemake.input.scene, params.cases, params.seeds, params.alternate)
    write_table(snakemake.output[0], table, DIGITS)
