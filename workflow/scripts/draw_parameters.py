"""Draw each parameter's error with its standard error."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.parameters import draw_parameters
    from study.plots.style import save_figure

    given = snakemake.input
    figure = draw_parameters(read_table(given.parameters), read_table(given.summary), snakemake.params.method)
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
