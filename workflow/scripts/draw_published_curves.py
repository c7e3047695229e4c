"""Draw what explains the published curves."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.published_curves import draw_curves, draw_recovery, draw_support
    from study.plots.style import save_figure

    given = snakemake.input
    candidates = read_table(given.candidates)
    figures = {
        "curves": lambda: draw_curves(candidates, read_table(given.predictions)),
        "support": lambda: draw_support(candidates),
        "recovery": lambda: draw_recovery(candidates, read_table(given.recovery)),
    }
    for name, draw in figures.items():
        save_figure(draw(), [snakemake.output[f"{name}_png"], snakemake.output[f"{name}_svg"]])
