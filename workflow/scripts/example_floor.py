"""Simulate and calibrate the worked example's cell without what is planted in it."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from scalar.data.dataset import read_dataset
    from scalar.estimation.calibrate import calibrate
    from study.worked_example.tell import write_floor

    cell = Path(snakemake.output.cell)
    write_floor(Path(snakemake.input.scene), cell)
    calibrate(read_dataset(cell / "dataset")).save(snakemake.output.calibration)
