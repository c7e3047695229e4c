"""Write the numbers of all sweeps, and where each published point falls among the simulated ones."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_table, write_table
    from study.sweeps.numbers import join_placed, sweep_numbers

    given, labels = snakemake.input, snakemake.params.labels
    errors = {name: read_table(path) for name, path in zip(labels, given.errors, strict=True)}
    placed = {name: read_table(path) for name, path in zip(labels, given.placed, strict=True)}
    write_table(snakemake.output.inside, join_placed(placed))
    write_json(snakemake.output.numbers, sweep_numbers(errors, placed, labels))
