"""Write what the poses of a case's first seed determine."""

from job import logged

with logged(snakemake.log):
    from study.common.seeds import found_seeds
    from study.common.tables import write_table
    from study.headline.identifiability import identifiability_tables

    _, folder = found_seeds(snakemake.input.data)[0]
    values, directions = identifiability_tables(folder / "dataset")
    write_table(snakemake.output.values, values)
    write_table(snakemake.output.directions, directions)
