"""Compute the errors of models without effects on held-out poses of a measured set."""

from job import logged

with logged(snakemake.log):
    from scalar.data.dataset import read_dataset
    from scalar.data.io.atomic import write_json
    from study.measured.models import compare

    write_json(snakemake.output[0], compare(read_dataset(snakemake.input.dataset)))
