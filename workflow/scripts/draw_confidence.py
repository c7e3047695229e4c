"""Draw the share of right answers against the stated confidence."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.confidence import draw_confidence
    from study.plots.style import save_figure

    save_figure(
        draw_confidence(read_table(snakemake.input.reliability)), [snakemake.output.png, snakemake.output.svg]
    )
