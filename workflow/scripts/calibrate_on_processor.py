"""Calibrate and evaluate the headline's datasets with the kernels of one processor."""

from job import logged

with logged(snakemake.log):
    from study.processors.repeat import repeat_on

    wanted = snakemake.params
    repeat_on(
        snakemake.wildcards.kernels, wanted.case, snakemake.input.data, wanted.methods, snakemake.output[0]
    )
