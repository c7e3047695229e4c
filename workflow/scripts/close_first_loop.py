"""Weigh what made the published curves go flat, and show what the weighing can tell apart."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_table, write_table
    from study.published_curves.analysis import close_first_loop
    from study.published_curves.predict import load_foretold

    given, params, output = snakemake.input, snakemake.params, snakemake.output
    sweeps = {name: read_table(path) for name, path in zip(params.sweeps, given.sweeps, strict=True)}
    foretold = load_foretold(given.foretold)
    found = close_first_loop(given.scene, read_table(given.published), sweeps, foretold, params.options)
    for name in ("candidates", "predictions", "recovery", "coverage"):
        write_table(output[name], getattr(found, name))
    write_json(output.numbers, found.numbers)
