"""Weigh the readings of the baseline's square root with leaning walls, and all explanations with the published run that the config leaves out."""

from job import logged

with logged(snakemake.log):
    import pandas as pd
    from scalar.data.io.atomic import write_json
    from study.common.provenance import code_version
    from study.common.tables import read_table, write_table
    from study.published_curves.leaning_support import weigh_leaning_walls

    given, output = snakemake.input, snakemake.output
    fits = pd.concat(list(map(read_table, given.fits)), ignore_index=True)
    table, numbers = weigh_leaning_walls(
        given.scene, read_table(given.published), fits, snakemake.params.options
    )
    write_table(output.table, table)
    write_json(output.numbers, {"code": code_version()} | numbers)
