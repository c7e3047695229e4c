"""Write what the poses of a case's first seed can show."""

from job import logged

with logged(snakemake.log):
    from study.observe import observe
    from study.seeds import found_seeds
    from study.tables import write_table

    _, folder = found_seeds(snakemake.input.data)[0]
    values, directions = observe(folder / "dataset")
    write_table(snakemake.output.values, values)
    write_table(snakemake.output.directions, directions)
