"""Fit the confidence to the answers of the trials, and report that of each half by the fit to the other."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.blind_trials.confidence_fit import answers_of, fitted, reliability, summary, with_confidence
    from study.common.provenance import code_version
    from study.common.tables import read_tables, write_table

    sets = read_tables(snakemake.input.sets)
    answers = answers_of(sets)
    stated = with_confidence(answers)
    write_json(snakemake.output.coefficients, fitted(answers))
    write_table(snakemake.output.answers, stated)
    write_table(snakemake.output.reliability, reliability(stated))
    write_json(snakemake.output.numbers, {"code": code_version(), "sets": len(sets)} | summary(stated))
