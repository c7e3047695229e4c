"""Pack a finished run into an RO-Crate."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from study.common.crate import write_crate

    given = snakemake.input
    write_crate(
        Path(snakemake.output[0]),
        root=Path(snakemake.params.root),
        results=sorted({Path(path) for path in [*given.results, *given.tables]}),
        config=snakemake.params.config,
    )
