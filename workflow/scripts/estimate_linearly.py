"""Write the errors of the linear estimate of the scanner's pose over the seeds."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import write_table
    from study.headline.linear_estimate import estimate_numbers, linear_estimates

    table = linear_estimates(list(snakemake.input.data))
    write_table(snakemake.output.table, table)
    write_json(snakemake.output.numbers, estimate_numbers(table))
