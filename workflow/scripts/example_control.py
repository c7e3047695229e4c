"""Simulate and calibrate the worked example's workcell without what is injected in it."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from scalar.data.dataset import read_dataset
    from scalar.estimation.calibrate import calibrate
    from study.worked_example.tables import write_control

    workcell = Path(snakemake.output.workcell)
    write_control(Path(snakemake.input.scene), workcell)
    calibrate(read_dataset(workcell / "dataset")).save(snakemake.output.calibration)
