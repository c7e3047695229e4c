"""Score the answers of the real-arm trials: rates, errors and faults."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_tables, write_table
    from study.real_arm_trials.summaries import summarise_real_arm

    numbers, tables = summarise_real_arm(read_tables(snakemake.input.sets), snakemake.params.design)
    for name, table in tables.items():
        write_table(snakemake.output[name], table)
    write_json(snakemake.output.numbers, numbers)
