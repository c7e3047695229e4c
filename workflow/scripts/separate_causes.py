"""Diagnose sets with few poses, plan further ones where causes are confounded, and diagnose again."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from study.blind_trials.cases import load_study
    from study.common.tables import write_table
    from study.planning.compare import DIGITS
    from study.planning.separate import Sizes, separate_sets

    study, at, params = load_study(snakemake.params.config), snakemake.wildcards, snakemake.params
    sizes = Sizes(**params.sizes)
    table = separate_sets(study, at.case, at.workcell, at.repetitions, Path(params.root), sizes)
    write_table(snakemake.output[0], table, DIGITS)
