"""Draw each parameter's error with its standard error."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import of_case, read_table
    from study.plots.parameters import draw_parameters
    from study.plots.style import name_case, save_figure

    given, params = snakemake.input, snakemake.params
    parameters, summary = (
        of_case(read_table(path), params.case) for path in (given.parameters, given.summary)
    )
    figure = draw_parameters(parameters, summary, params.method)
    if snakemake.wildcards.case_suffix:
        name_case(figure, params.case)
    save_figure(figure, [snakemake.output.png, snakemake.output.svg])
