"""Score a closed loop: its tables and its numbers."""

from job import logged

with logged(snakemake.log):
    from scalar.atomic import write_json
    from scalar.study.closed_loop.cases import load_study
    from scalar.study.closed_loop.numbers import summarise
    from scalar.study.tables import read_tables, write_table

    numbers, tables = summarise(read_tables(snakemake.input.sets), load_study(snakemake.params.config))
    for name, table in tables.items():
        write_table(snakemake.output[name], table)
    write_json(snakemake.output.numbers, numbers)
