"""Draw the comparison of orders."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.sequential import draw_sequential
    from study.plots.style import save_figure

    given, wanted = snakemake.input, snakemake.output
    figure = draw_sequential(read_table(given.errors), read_table(given.summary))
    save_figure(figure, [wanted.png, wanted.svg])
