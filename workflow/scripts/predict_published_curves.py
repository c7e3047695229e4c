"""Predict the published curves under every candidate."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.published_curves.predict import predict_runs

    given = snakemake.input
    predict_runs(given.scene, read_table(given.published), snakemake.params.options).save(snakemake.output[0])
