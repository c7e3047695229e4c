"""Draw the simulated initial models and the published one."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import of_case, read_table
    from study.plots.initial import draw_initial
    from study.plots.style import save_figure

    given, case = snakemake.input, snakemake.params.case
    figure = draw_initial(of_case(read_table(given.errors), case), read_table(given.placed))
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
