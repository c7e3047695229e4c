"""Draw the workcell of the headline by pybullet's renderer."""

from job import logged

with logged(snakemake.log):
    from study.headline.picture import write_picture

    given, wanted, params = snakemake.input, snakemake.output, snakemake.params
    write_picture(given.scene, params.overrides, params.seed, wanted.picture, wanted.places)
