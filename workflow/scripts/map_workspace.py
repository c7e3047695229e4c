"""Map the position errors of all seeds over the workspace."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import write_table
    from study.headline.workspace import map_errors

    given, wanted = snakemake.input, snakemake.output
    errors, seeds = map_errors(given.data, given.calibrations)
    write_table(wanted.errors, errors, 6)
    write_json(wanted.seeds, {"seeds": seeds})
