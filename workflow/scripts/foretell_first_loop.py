"""Predict the published curves under every candidate."""

from job import logged

with logged(snakemake.log):
    from scalar.study.first_loop.foretell import foretell
    from scalar.study.tables import read_table

    given = snakemake.input
    foretell(given.scene, read_table(given.published), snakemake.params.options).save(snakemake.output[0])
