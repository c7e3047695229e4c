"""Draw the planes against the truth."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import of_case, read_table
    from study.plots.planes import draw_planes
    from study.plots.style import name_case, save_figure

    given, case = snakemake.input, snakemake.params.case
    figure = draw_planes(of_case(read_table(given.planes), case), read_table(given.published))
    if snakemake.wildcards.case_suffix:
        name_case(figure, case)
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
