"""Join the tables of a study's cases and batches, and summarise them over the seeds."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table, read_tables, write_table
    from study.headline.summary import summarise_errors, summarise_parameters, summarise_planes

    errors = read_tables(snakemake.input.errors)
    planes = read_tables(snakemake.input.planes)
    parameters = read_tables(snakemake.input.parameters)
    write_table(snakemake.output.errors, errors)
    write_table(snakemake.output.planes, planes)
    write_table(snakemake.output.parameters, parameters)
    write_table(snakemake.output.summary, summarise_errors(errors))
    write_table(snakemake.output.parameter_summary, summarise_parameters(parameters))
    published = read_table(snakemake.input.published_planes)
    write_table(snakemake.output.plane_summary, summarise_planes(planes, published))
