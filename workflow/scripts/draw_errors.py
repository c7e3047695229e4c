"""Draw the errors before and after calibration."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import of_case, read_table
    from study.plots.errors import draw_errors
    from study.plots.style import name_case, save_figure

    given, case = snakemake.input, snakemake.params.case
    errors, summary = (of_case(read_table(path), case) for path in (given.errors, given.summary))
    figure = draw_errors(errors, summary, read_table(given.published))
    if snakemake.wildcards.case_suffix:
        name_case(figure, case)
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
