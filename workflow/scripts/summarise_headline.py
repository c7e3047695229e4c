"""Write the numbers of the headline, and where the published values fall among the simulated ones."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import of_case, read_table, write_table
    from study.headline.summary import headline_numbers, place_published

    given, case = snakemake.input, snakemake.params.case
    placed = place_published(of_case(read_table(given.errors), case), read_table(given.published))
    write_table(snakemake.output.placed, placed)
    numbers = headline_numbers(
        of_case(read_table(given.summary), case),
        placed,
        of_case(read_table(given.plane_summary), case),
        of_case(read_table(given.parameter_summary), case),
        read_table(given.values),
        read_table(given.directions),
    )
    write_json(snakemake.output.numbers, numbers)
