"""Draw the singular values."""

from job import logged

with logged(snakemake.log):
    from scalar.plots.identifiability import draw_singular_values
    from scalar.plots.style import save_figure
    from scalar.study.tables import read_table

    given = snakemake.input
    figure = draw_singular_values(read_table(given.values), read_table(given.directions))
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
