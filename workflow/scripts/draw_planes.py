"""Draw the planes against the truth."""

from job import logged

with logged(snakemake.log):
    from scalar.plots.planes import draw_planes
    from scalar.plots.style import save_figure
    from scalar.study.tables import read_table

    given = snakemake.input
    figure = draw_planes(read_table(given.planes), read_table(given.published))
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
