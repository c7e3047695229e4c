"""Score the stratified blind trials: the table of rates with intervals, ratios of errors, reliability."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.blind_trials.stratified_summaries import summarise_trials
    from study.common.tables import read_tables, write_table

    numbers, tables = summarise_trials(read_tables(snakemake.input.sets), snakemake.params.design)
    for name, table in tables.items():
        write_table(snakemake.output[name], table)
    write_json(snakemake.output.numbers, numbers)
