"""Calibrate a measured set with the effects of another campaign fixed, and predict held-out poses."""

from job import logged

with logged(snakemake.log):
    from scalar.data.dataset import read_dataset
    from scalar.data.io.atomic import write_json
    from scalar.estimation.calibrate import calibrate
    from scalar.estimation.result import load_calibration
    from scalar.estimation.transfer import carried
    from study.measured.models import transferred

    data = read_dataset(snakemake.input.dataset)
    given = carried(load_calibration(snakemake.input.effects).model, data)
    effects = given.effects
    for effect, reason in given.left:
        print(f"not taken: {effect.key}: {reason}", flush=True)
    calibrate(data, fixed_effects=effects).save(snakemake.output.calibration)
    write_json(snakemake.output.errors, {f"effects_of_{snakemake.params.source}": transferred(data, effects)})
