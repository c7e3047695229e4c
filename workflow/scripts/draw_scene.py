"""Draw the workcell with names on its parts."""

from job import logged

with logged(snakemake.log):
    import json
    from pathlib import Path

    from study.plots.scene import draw_scene
    from study.plots.style import save_figure

    given, wanted = snakemake.input, snakemake.output
    places = json.loads(Path(given.places).read_text(encoding="utf-8"))
    save_figure(draw_scene(given.picture, places), [wanted.png, wanted.svg])
