"""Write the numbers of the headline, and where the published values fall among ours."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_table, write_table
    from study.headline.summary import headline_numbers, place_published

    given = snakemake.input
    placed = place_published(read_table(given.errors), read_table(given.published))
    write_table(snakemake.output.placed, placed)
    numbers = headline_numbers(
        read_table(given.summary),
        placed,
        read_table(given.plane_summary),
        read_table(given.parameter_summary),
        read_table(given.values),
        read_table(given.directions),
    )
    write_json(snakemake.output.numbers, numbers)
