"""Draw the planes against the truth."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.planes import draw_planes
    from study.plots.style import save_figure

    given = snakemake.input
    figure = draw_planes(read_table(given.planes), read_table(given.published))
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
