"""Write the correlations of the parameters of a batch's first calibration."""

from job import logged

with logged(snakemake.log):
    from scalar.estimation.result import load_calibration
    from study.common.seeds import found_seeds
    from study.common.tables import write_table
    from study.headline.workspace import correlation

    _, path = found_seeds(snakemake.input.calibrations)[0]
    write_table(snakemake.output[0], correlation(load_calibration(path)), 6)
