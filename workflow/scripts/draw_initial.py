"""Draw our initial models and the published one."""

from job import logged

with logged(snakemake.log):
    from scalar.plots.initial import draw_initial
    from scalar.plots.style import save_figure
    from scalar.study.tables import read_table

    given = snakemake.input
    figure = draw_initial(read_table(given.errors), read_table(given.placed))
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
