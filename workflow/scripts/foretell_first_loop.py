"""Predict the published curves under every candidate."""

from job import logged

with logged(snakemake.log):
    from study.published_curves.predict import foretell
    from study.tables import read_table

    given = snakemake.input
    foretell(given.scene, read_table(given.published), snakemake.params.options).save(snakemake.output[0])
