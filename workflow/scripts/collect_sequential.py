"""Join the errors of calibrations at once and one after the other, and summarise them over the seeds."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_tables, write_table
    from study.sequential.summary import sequential_numbers, summarise_sequential

    wanted = snakemake.output
    errors = read_tables(snakemake.input.tables)
    summary = summarise_sequential(errors)
    write_table(wanted.errors, errors)
    write_table(wanted.summary, summary)
    write_json(wanted.numbers, sequential_numbers(errors, summary))
