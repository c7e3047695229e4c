"""Draw the correlations of the parameters."""

from job import logged

with logged(snakemake.log):
    from scalar.plots.correlation import draw_correlation
    from scalar.plots.style import save_figure
    from scalar.study.tables import read_table

    given, wanted = snakemake.input, snakemake.output
    save_figure(draw_correlation(read_table(given.correlation)), [wanted.png, wanted.svg])
