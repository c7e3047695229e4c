"""Draw the correlations of the parameters."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.correlation import draw_correlation
    from study.plots.style import save_figure

    given, wanted = snakemake.input, snakemake.output
    save_figure(draw_correlation(read_table(given.correlation)), [wanted.png, wanted.svg])
