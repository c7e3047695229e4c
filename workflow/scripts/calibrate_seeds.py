"""Calibrate the datasets of a batch of seeds by one method."""

from job import logged

with logged(snakemake.log):
    from study.headline.calibrate import calibrate_seeds

    calibrate_seeds(snakemake.input.data, snakemake.params.method, snakemake.output[0])
