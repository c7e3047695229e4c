"""Draw all sweeps at a glance, for one kind of walls."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.style import save_figure
    from study.plots.sweep_overview import draw_overview

    given, params = snakemake.input, snakemake.params
    tables = {name: read_table(path) for name, path in zip(params.axes, given.summaries, strict=True)}
    of_walls = {name: table[table["walls"] == params.walls] for name, table in tables.items()}
    figure = draw_overview(of_walls, read_table(given.published), params.axes)
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
