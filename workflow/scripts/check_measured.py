"""Check what was found in a measured set, and tabulate the errors of its gears."""

from job import logged

with logged(snakemake.log):
    from scalar.data.dataset import read_dataset
    from scalar.data.io.atomic import write_json
    from scalar.estimation.result import load_calibration
    from study.common.tables import write_table
    from study.measured.gears import gear_errors
    from study.measured.models import on_a_fresh_split, on_shuffled_angles

    data, found = read_dataset(snakemake.input.dataset), load_calibration(snakemake.input.found)
    checks = {"fresh_split": on_a_fresh_split(data, found), "shuffled": on_shuffled_angles(data, found)}
    write_json(snakemake.output.checks, checks)
    write_table(snakemake.output.gears, gear_errors(found, data), digits=4)
