"""Draw the worked example."""

from job import logged

with logged(snakemake.log):
    from scalar.plots.style import save_figure
    from scalar.plots.worked_example import draw_worked_example
    from scalar.study.tables import read_table
    from scalar.study.worked_example import read

    given = snakemake.input
    tables = [read_table(given[name]) for name in ("poses", "curve", "ranking", "errors")]
    save_figure(
        draw_worked_example(*tables, read(given.numbers)), [snakemake.output.png, snakemake.output.svg]
    )
