"""Simulate the datasets of a batch of seeds."""

from job import logged

with logged(snakemake.log):
    from study.headline.simulate import simulate_seeds

    simulate_seeds(
        snakemake.input.scene, snakemake.params.overrides, snakemake.params.seeds, snakemake.output[0]
    )
