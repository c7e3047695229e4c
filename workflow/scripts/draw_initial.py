"""Draw our initial models and the published one."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.initial import draw_initial
    from study.plots.style import save_figure

    given = snakemake.input
    figure = draw_initial(read_table(given.errors), read_table(given.placed))
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
