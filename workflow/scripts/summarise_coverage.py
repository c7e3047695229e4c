"""Summarise the study of coverage."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_tables, write_table
    from study.coverage.summaries import summarise_coverage

    numbers, table = summarise_coverage(read_tables(snakemake.input.workcells), snakemake.params.design)
    write_table(snakemake.output.table, table)
    write_json(snakemake.output.numbers, numbers)
