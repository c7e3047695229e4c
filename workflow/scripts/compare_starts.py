"""Start both methods from the start of either, over the sweeps of the initial guesses, all walls and seeds."""

from job import logged

with logged(snakemake.log):
    import itertools

    import pandas as pd
    from scalar.data.io.atomic import write_json
    from study.common.provenance import code_version
    from study.common.tables import write_table
    from study.sweeps.plans import read_plans
    from study.sweeps.run import DIGITS
    from study.sweeps.starts import START_COLUMNS, compare_starts, start_numbers

    given, params = snakemake.input, snakemake.params
    paths = dict(zip(itertools.product(params.walls, params.seeds), given.plans, strict=True))
    tables = []
    for (axis, cases), (walls, scene), (batch, seeds) in itertools.product(
        params.cases.items(), zip(params.walls, given.scenes, strict=True), params.seeds.items()
    ):
        table = compare_starts(scene, cases, seeds, read_plans(paths[walls, batch]))
        value = table["case"].map(params.values[axis])
        tables.append(table.assign(axis=axis, walls=walls, value=value))
    whole = pd.concat(tables, ignore_index=True)[list(START_COLUMNS)]
    write_table(snakemake.output.table, whole, DIGITS)
    write_json(snakemake.output.numbers, {"code": code_version()} | start_numbers(whole))
