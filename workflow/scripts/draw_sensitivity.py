"""Draw how many answers change with each setting."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.sensitivity import draw_sensitivity
    from study.plots.style import save_figure

    save_figure(
        draw_sensitivity(read_table(snakemake.input.table)), [snakemake.output.png, snakemake.output.svg]
    )
