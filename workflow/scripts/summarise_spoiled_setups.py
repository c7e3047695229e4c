"""Summarise the spoiled set-ups: outcomes with intervals, and the sets that are not named right."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_tables, write_table
    from study.spoiled_setups.summaries import summarise_spoiled

    numbers, tables = summarise_spoiled(read_tables(snakemake.input.sets), snakemake.params.design)
    for name, table in tables.items():
        write_table(snakemake.output[name], table)
    write_json(snakemake.output.numbers, numbers)
