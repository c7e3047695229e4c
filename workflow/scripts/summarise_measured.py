"""Summarise the measured sets, with the checksums of the data they come from."""

from job import logged

with logged(snakemake.log):
    import json
    from pathlib import Path

    from scalar.atomic import write_json
    from scalar.study.measured import summarise
    from scalar.study.originals import checksums
    from scalar.study.tables import write_table

    def read(path):
        return json.loads(Path(path).read_text(encoding="utf-8"))

    given, sets = snakemake.input, snakemake.params.sets
    files = {name: checksums(path) for name, path in zip(sets, given.originals, strict=True)}
    diagnoses = {name: read(path) for name, path in zip(sets, given.diagnoses, strict=True)}
    errors = {name: read(path) for name, path in zip(sets, given.errors, strict=True)}
    for name, path in zip(snakemake.params.transfers, given.transfers, strict=True):
        errors[name] |= read(path)
    summary, table = summarise(files, diagnoses, errors)
    write_json(snakemake.output.summary, summary)
    write_table(snakemake.output.table, table)
