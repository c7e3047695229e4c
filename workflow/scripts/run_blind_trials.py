"""Inject and diagnose the sets of one case, workcell and batch of repetitions."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from study.blind_trials.cases import load_study
    from study.blind_trials.run import run_sets
    from study.common.tables import write_table

    study, at, params = load_study(snakemake.params.config), snakemake.wildcards, snakemake.params
    write_table(snakemake.output[0], run_sets(study, at.case, at.workcell, at.repetitions, Path(params.root)))
