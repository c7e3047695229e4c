"""Draw the figures of the closed loop from its summaries."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from scalar.plots import closed_loop
    from scalar.plots.style import save_figure
    from scalar.study.tables import read_table

    tables = {Path(path).stem: read_table(path) for path in snakemake.input.summaries}
    figures = {
        "confusion": lambda: closed_loop.draw_confusion(tables["confusion"]),
        "power": lambda: closed_loop.draw_power(tables["power"], tables["thresholds"]),
        "errors": lambda: closed_loop.draw_errors_after(tables["errors"]),
        "reliability": lambda: closed_loop.draw_reliability(tables["reliability"]),
    }
    for name in snakemake.params.figures:
        save_figure(figures[name](), [snakemake.output[f"{name}_png"], snakemake.output[f"{name}_svg"]])
