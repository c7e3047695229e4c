"""Evaluate the calibrations of a batch of seeds against the truth."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import write_table
    from study.headline.evaluate import evaluate_seeds

    calibrations = dict(zip(snakemake.params.methods, snakemake.input.calibrations, strict=True))
    found = evaluate_seeds(snakemake.params.case, snakemake.input.data, calibrations)
    write_table(snakemake.output.errors, found.errors)
    write_table(snakemake.output.planes, found.planes)
    write_table(snakemake.output.parameters, found.parameters)
