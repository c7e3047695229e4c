"""Get the original files of a measured set, from a local folder or the network."""

from job import logged

with logged(snakemake.log):
    from study.measured.originals import get_originals, read_originals

    originals = read_originals(snakemake.params.listed)[snakemake.wildcards.set]
    get_originals(originals, snakemake.resources.folder, snakemake.params.addresses, snakemake.output[0])
