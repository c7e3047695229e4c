"""Score the tracked trials: rates with intervals, causes, nulls, errors and faults."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_tables, write_table
    from study.tracked_trials.summaries import summarise_tracked

    numbers, tables = summarise_tracked(read_tables(snakemake.input.sets), snakemake.params.design)
    for name, table in tables.items():
        write_table(snakemake.output[name], table)
    write_json(snakemake.output.numbers, numbers)
