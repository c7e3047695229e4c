"""Typeset the paper."""

from job import logged

with logged(snakemake.log):
    import json
    from pathlib import Path

    from study.paper.typeset import write_paper

    numbers = json.loads(Path(snakemake.input.numbers).read_text(encoding="utf-8"))
    figures = {place: Path(source) for place, source in snakemake.params.figures.items()}
    write_paper(snakemake.output[0], Path(snakemake.params.text), numbers, figures)
