"""Write the correlations of the parameters of a batch's first calibration."""

from job import logged

with logged(snakemake.log):
    from scalar.calibration import load_calibration
    from scalar.study.seeds import found_seeds
    from scalar.study.tables import write_table
    from scalar.study.workspace import correlation

    _, path = found_seeds(snakemake.input.calibrations)[0]
    write_table(snakemake.output[0], correlation(load_calibration(path)), 6)
