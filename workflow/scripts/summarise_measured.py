"""Summarise the measured sets, with the checksums of their original files."""

from job import logged

with logged(snakemake.log):
    import json
    from pathlib import Path

    from scalar.data.dataset import read_dataset
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_table, write_table
    from study.measured.gears import agreement
    from study.measured.models import summarise
    from study.measured.originals import checksums
    from study.measured.repeated import floor_of

    def read(path):
        return json.loads(Path(path).read_text(encoding="utf-8"))

    given, sets, transfers = snakemake.input, snakemake.params.sets, snakemake.params.transfers
    files = {name: checksums(path) for name, path in zip(sets, given.originals, strict=True)}
    diagnoses = {name: read(path) for name, path in zip(sets, given.diagnoses, strict=True)}
    errors = {name: read(path) for name, path in zip(sets, given.errors, strict=True)}
    for name, path in zip(transfers, given.transfers, strict=True):
        errors[name] |= read(path)
    checks = {name: read(path) for name, path in zip(sets, given.checks, strict=True)}
    gears = {name: read_table(path).assign(set=name) for name, path in zip(sets, given.gears, strict=True)}
    agreements = {
        f"{name}_and_{other}": agreement(gears[name], gears[other]) for name, other in transfers.items()
    }
    floors = {name: floor_of(read_dataset(path)) for name, path in zip(sets, given.datasets, strict=True)}
    summary, table, curves = summarise(files, diagnoses, errors, checks, gears, agreements, floors)
    write_json(snakemake.output.summary, summary)
    write_table(snakemake.output.table, table)
    write_table(snakemake.output.gears, curves, digits=4)
