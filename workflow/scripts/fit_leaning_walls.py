"""Fit the published runs with walls that lean."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table, write_table
    from study.published_curves.leaning_walls import fit_leaning_walls
    from study.sweeps.run import DIGITS

    given, params = snakemake.input, snakemake.params
    table = fit_leaning_walls(
        given.scene, read_table(given.published), params.options, params.lean_deg, params.seeds
    )
    write_table(snakemake.output[0], table, DIGITS)
