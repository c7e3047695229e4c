"""Diagnose a measured set."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from scalar.data.dataset import read_dataset
    from scalar.diagnosis import diagnose
    from scalar.report.output import write_diagnosis

    found = diagnose(read_dataset(snakemake.input.dataset), progress=lambda stage: print(stage, flush=True))
    write_diagnosis(found, Path(snakemake.output.diagnosis).parent)
