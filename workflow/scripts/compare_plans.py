"""Calibrate planned and random poses for a batch of seeds."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import write_table
    from study.planning.compare import DIGITS, compare_plans

    params = snakemake.params
    table = compare_plans(snakemake.input.scene, params.seeds, params.sizes, params.pool_per_plane)
    write_table(snakemake.output[0], table, DIGITS)
