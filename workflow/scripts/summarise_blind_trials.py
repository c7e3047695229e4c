"""Score the blind trials: their tables and their numbers."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.blind_trials.cases import load_study
    from study.blind_trials.numbers import summarise
    from study.common.tables import read_tables, write_table

    numbers, tables = summarise(read_tables(snakemake.input.sets), load_study(snakemake.params.config))
    for name, table in tables.items():
        write_table(snakemake.output[name], table)
    write_json(snakemake.output.numbers, numbers)
