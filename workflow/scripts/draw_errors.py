"""Draw the errors before and after calibration."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.errors import draw_errors
    from study.plots.style import save_figure

    given = snakemake.input
    figure = draw_errors(read_table(given.errors), read_table(given.summary), read_table(given.published))
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
