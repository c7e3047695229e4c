"""Draw the figures of the blind trials from their summaries."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from study.common.tables import read_table
    from study.plots import blind_trials
    from study.plots.style import save_figure

    tables = {Path(path).stem: read_table(path) for path in snakemake.input.summaries}
    figures = {
        "confusion": lambda: blind_trials.draw_confusion(tables["confusion"]),
        "power": lambda: blind_trials.draw_power(tables["power"], tables["thresholds"]),
        "errors": lambda: blind_trials.draw_errors_after(tables["errors"]),
        "reliability": lambda: blind_trials.draw_reliability(tables["reliability"]),
    }
    for name in snakemake.params.figures:
        save_figure(figures[name](), [snakemake.output[f"{name}_png"], snakemake.output[f"{name}_svg"]])
