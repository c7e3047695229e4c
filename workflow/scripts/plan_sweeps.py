"""Find the postures and true scans of a batch of seeds that all sweeps share."""

from job import logged

with logged(snakemake.log):
    from study.sweeps.plans import write_plans

    params = snakemake.params
    write_plans(snakemake.input.scene, params.poses, params.seeds, snakemake.output[0])
