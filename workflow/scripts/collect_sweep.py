"""Join the cases of a sweep, summarise them over the seeds, and place the published points among them."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table, write_table
    from study.sweeps.summary import join_cases, place_published_curve, summarise_sweep

    given, params = snakemake.input, snakemake.params
    errors = join_cases([read_table(path) for path in given.tables], params.values)
    curves = read_table(given.published)
    write_table(snakemake.output.errors, errors)
    write_table(snakemake.output.summary, summarise_sweep(errors))
    placed = place_published_curve(errors, curves[curves["sweep"] == params.published])
    write_table(snakemake.output.placed, placed)
