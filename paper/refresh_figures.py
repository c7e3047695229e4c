"""Copy the figures that the README shows from results/ to paper/figures/, small enough for a repository: make readme-figures."""

from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[1]
WIDTH, COLOURS = 1200, 256  # pixels; a palette: line drawings need no more
FIGURES = {  # {name in paper/figures: file in results}
    "headline_errors.png": "headline/figures/errors.png",
    "sweeps.png": "sweeps/figures/overview_upright.png",
    "worked_example.png": "worked_example/figures/worked_example.png",
    "blind_trials.png": "paper/blind_trials/confusion.png",
    "gears.png": "paper/measured/gears.png",
}

for name, source in FIGURES.items():
    path = ROOT / "results" / source
    if not path.exists():
        print(f"{path.relative_to(ROOT)} is not there: run the workflow first (make); {name} stays as it is")
        continue
    picture = Image.open(path).convert("RGB")
    picture.thumbnail((WIDTH, WIDTH), Image.Resampling.LANCZOS)
    target = ROOT / "paper/figures" / name
    # The median cut, the usual method, gives pale colours of small areas the hue of larger ones.
    palette = picture.quantize(COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    palette.save(target, optimize=True)
    print(f"{target.relative_to(ROOT)}: {target.stat().st_size // 1000} kB")
