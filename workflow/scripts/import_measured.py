"""Import a measured set from its originals."""

from job import logged

with logged(snakemake.log):
    from scalar.ingest.convert import import_dataset

    import_dataset(snakemake.input.mapping, [snakemake.input.originals], snakemake.output[0])
