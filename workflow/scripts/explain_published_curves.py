"""Weigh explanations of the flat published curves, and test which of them can be distinguished."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_table, write_table
    from study.published_curves.explain import explain_published_curves
    from study.published_curves.predict import load_predictions

    given, params, output = snakemake.input, snakemake.params, snakemake.output
    sweeps = {name: read_table(path) for name, path in zip(params.sweeps, given.sweeps, strict=True)}
    predicted = load_predictions(given.predicted)
    found = explain_published_curves(
        given.scene, read_table(given.published), sweeps, predicted, params.options
    )
    for name in ("candidates", "predictions", "recovery", "coverage"):
        write_table(output[name], getattr(found, name))
    write_json(output.numbers, found.numbers)
