"""Draw a sweep for one kind of walls."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.style import save_figure
    from study.plots.sweep import draw_sweep

    given, axis = snakemake.input, snakemake.params.axis
    summary, curves = read_table(given.summary), read_table(given.published)
    figure = draw_sweep(
        summary[summary["walls"] == snakemake.params.walls],
        curves[curves["sweep"] == axis.get("published")],
        axis["label"],
        axis.get("scale", "log"),
    )
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
