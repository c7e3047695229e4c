"""Check what was found in a measured set, and tabulate the errors of its gears."""

from job import logged

with logged(snakemake.log):
    from scalar.atomic import write_json
    from scalar.calibration import load_calibration
    from scalar.dataset import read_dataset
    from scalar.study.gears import gear_errors
    from scalar.study.measured import on_a_fresh_split, on_shuffled_angles
    from scalar.study.tables import write_table

    data, found = read_dataset(snakemake.input.dataset), load_calibration(snakemake.input.found)
    checks = {"fresh_split": on_a_fresh_split(data, found), "shuffled": on_shuffled_angles(data, found)}
    write_json(snakemake.output.checks, checks)
    write_table(snakemake.output.gears, gear_errors(found, data), digits=4)
