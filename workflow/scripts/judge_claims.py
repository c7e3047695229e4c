"""Judge every claim of the paper by the tables of this run."""

from job import logged

with logged(snakemake.log):
    import json
    from pathlib import Path

    import pandas as pd
    from scalar.data.io.atomic import write_json
    from study.claims.answers import Results
    from study.claims.judge import judge_claims
    from study.claims.numbers import claim_numbers
    from study.common.tables import of_case, read_table, write_table

    given, wanted, params = snakemake.input, snakemake.output, snakemake.params
    seconds = {  # a job's whole time, imports and all, over its seeds: more than a fit takes
        method: sum(pd.read_csv(path, sep="\t")["s"].iloc[0] for path in paths) / params.seeds
        for method, paths in params.benchmarks.items()
        if all(Path(path).exists() for path in paths)
    }
    results = Results(
        headline=of_case(read_table(given.headline), params.case),
        planes=of_case(read_table(given.planes), params.case),
        singular_values=read_table(given.singular_values),
        arms=read_table(given.arms),
        workspace=read_table(given.workspace).assign(seeds=json.loads(Path(given.seeds).read_text())["seeds"])
        if given.workspace
        else None,
        sequential=read_table(given.sequential) if given.sequential else None,
        sweeps={name: read_table(path) for name, path in zip(params.sweeps, given.sweeps, strict=True)},
        seconds=seconds,
    )
    table = judge_claims(read_table(given.claims), results)
    write_table(wanted.table, table, 6)
    write_json(wanted.numbers, claim_numbers(table))
