"""Halve and double settings on one blind set."""

from job import logged

with logged(snakemake.log):
    import json
    from pathlib import Path

    from study.common.tables import write_table
    from study.sensitivity.datasets import make_dataset
    from study.sensitivity.sets import load_sets
    from study.sensitivity.variants import variants
    from study.sensitivity.vary import answering, vary

    sets, name = load_sets(snakemake.params.config), snakemake.wildcards.blind_set
    screened = snakemake.input.get("screened")
    names = json.loads(Path(screened).read_text(encoding="utf-8")) if screened else None
    dataset, truth_poses = make_dataset(sets.sets[name], sets, Path(snakemake.params.root))
    write_table(snakemake.output[0], vary(name, answering(dataset, truth_poses), variants(names)))
