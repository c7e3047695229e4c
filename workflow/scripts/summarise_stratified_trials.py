"""Score the stratified blind trials: the table of rates with intervals, ratios of errors, reliability."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.blind_trials.outer_split_summary import split_numbers, split_rates
    from study.blind_trials.stratified_summaries import summarise_trials
    from study.common.tables import read_tables, write_table

    sets = read_tables(snakemake.input.sets)
    numbers, tables = summarise_trials(sets, snakemake.params.design)
    if "outer_split" in snakemake.params.design:
        numbers["outer_split"], tables["outer_split"] = split_numbers(sets), split_rates(sets)
    for name, table in tables.items():
        write_table(snakemake.output[name], table)
    write_json(snakemake.output.numbers, numbers)
