"""Run some cases of a sweep over all walls and a batch of seeds."""

from job import logged

with logged(snakemake.log):
    from study.common.tables import write_table
    from study.sweeps.run import DIGITS, sweep_cases

    given, params = snakemake.input, snakemake.params
    scenes, plans = (dict(zip(params.walls, paths, strict=True)) for paths in (given.scenes, given.plans))
    table = sweep_cases(params.cases, scenes, params.seeds, params.methods, plans)
    write_table(snakemake.output[0], table, DIGITS)
