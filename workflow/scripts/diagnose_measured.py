"""Diagnose a measured set; for its errors on unseen poses, repeat the diagnosis without each part of the poses in turn."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from scalar.data.dataset import read_dataset
    from scalar.diagnosis import diagnose
    from scalar.diagnosis.settings import DEFAULTS
    from scalar.report.output import write_diagnosis

    found = diagnose(
        read_dataset(snakemake.input.dataset),
        progress=lambda stage: print(stage, flush=True),
        outer_folds=DEFAULTS.hold_out.folds,
        on_fold=lambda done, total: print(
            f"{done} of {total} diagnoses without a part of the poses", flush=True
        ),
    )
    write_diagnosis(found, Path(snakemake.output.diagnosis).parent)
