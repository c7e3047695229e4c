"""Spoil simulated datasets by degrees along each axis, and diagnose them."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from study.common.tables import write_table
    from study.edges.run import run_edges

    params = snakemake.params
    table = run_edges(Path(snakemake.input.scene), params["degrees"], params.seeds)
    write_table(snakemake.output[0], table)
