"""Draw the diagnoses of spoiled data."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.edges import draw_edges
    from study.plots.style import save_figure

    given, drawn = snakemake.input, snakemake.output
    save_figure(draw_edges(read_table(given.edges), read_table(given.summary)), [drawn.png, drawn.svg])
