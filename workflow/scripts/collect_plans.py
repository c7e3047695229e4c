"""Join the batches of planned and random poses, and summarise them over the seeds."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.provenance import code_version
    from study.common.tables import read_tables, write_table
    from study.planning.summary import planning_numbers, summarise_planning

    errors = read_tables(snakemake.input.tables)
    write_table(snakemake.output.errors, errors)
    write_table(snakemake.output.summary, summarise_planning(errors))
    write_json(snakemake.output.numbers, {"code": code_version()} | planning_numbers(errors))
