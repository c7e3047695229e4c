"""Draw the singular values."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.identifiability import draw_singular_values
    from study.plots.style import save_figure

    given = snakemake.input
    figure = draw_singular_values(read_table(given.values), read_table(given.directions))
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
