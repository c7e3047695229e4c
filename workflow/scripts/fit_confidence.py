"""Fit the confidence to the answers of the trials, and report that of each half by the fit to the other."""

from job import logged

with logged(snakemake.log):
    import pandas as pd
    from scalar.data.io.atomic import write_json
    from study.common.provenance import code_version
    from study.common.tables import read_tables, write_table
    from study.confidence.answers import answers_of, tracked_answers_of
    from study.confidence.fit import (
        fitted,
        reliability,
        reliability_by_poses,
        summary,
        with_confidence,
    )

    sets, tracked = read_tables(snakemake.input.sets), read_tables(snakemake.input.tracked)
    answers = pd.concat([answers_of(sets), tracked_answers_of(tracked)], ignore_index=True)
    stated = with_confidence(answers)
    write_json(snakemake.output.coefficients, fitted(answers))
    write_table(snakemake.output.answers, stated)
    write_table(snakemake.output.reliability, reliability(stated))
    write_table(snakemake.output.by_poses, reliability_by_poses(stated))
    numbers = {"code": code_version(), "sets": len(sets) + len(tracked), "tracked_sets": len(tracked)}
    write_json(snakemake.output.numbers, numbers | summary(stated))
