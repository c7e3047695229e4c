"""Draw the worked example."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import read_table
    from study.plots.style import save_figure
    from study.plots.worked_example import draw_worked_example
    from study.worked_example.tables import read

    given = snakemake.input
    tables = [read_table(given[name]) for name in ("poses", "curve", "ranking", "errors")]
    save_figure(
        draw_worked_example(*tables, read(given.numbers)), [snakemake.output.png, snakemake.output.svg]
    )
