"""Draw the map of errors over the workspace."""

from job import logged

with logged(snakemake.log):
    import json
    from pathlib import Path

    from study.common.tables import read_table
    from study.plots.style import save_figure
    from study.plots.workspace import draw_workspace

    given, wanted = snakemake.input, snakemake.output
    seeds = json.loads(Path(given.seeds).read_text(encoding="utf-8"))["seeds"]
    save_figure(draw_workspace(read_table(given.errors), seeds), [wanted.png, wanted.svg])
