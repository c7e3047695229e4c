"""Draw the measured robots: errors of every model, and errors of the gears over their angles."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.measured import draw_errors, draw_gears
    from study.plots.style import save_figure

    figures = {
        "errors": draw_errors(read_table(snakemake.input.errors)),
        "gears": draw_gears(read_table(snakemake.input.gears)),
    }
    for name, figure in figures.items():
        save_figure(figure, [snakemake.output[f"{name}_png"], snakemake.output[f"{name}_svg"]])
