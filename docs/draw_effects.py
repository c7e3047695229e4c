"""Draw docs/pictures/effects: each effect in simulated data, without and with it in the model. Run by `make docs-pictures`, not with each build.

python -m docs.draw_effects [NAME ...]
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image
from study.plots.style import save_figure, styled

from docs.draw_noises import noise_figure
from docs.site.catalogue import CATALOGUE, NOISES, Shown, effect_of, simulated
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.partial_residuals import FittedView
from scalar.effects.effect import Effect
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from scalar.effects.picture import Map, Profile
from scalar.estimation.conclude import conclude
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.joint_fit import fit_from
from scalar.report.axes import in_words, range_of, shown

PICTURES = Path(__file__).parent / "pictures/effects"
POSES_PER_PLANE = 60
ORANGE, BLUE, DOT = "#d55e00", "#0072b2", "#5b6770"
_COLOUR_SCALE = 0.98  # quantile of the sizes at which the colours of a map end
_SHOWN = 0.99  # share of the dots that lie within the axes
_COLOURS = 64  # of a picture as a file


def pictures_of(name: str, entry: Shown) -> list[Profile | Map]:
    """Return the report's pictures of an effect that is injected and fitted."""
    dataset = simulated(entry, poses_per_plane=POSES_PER_PLANE)
    effect: Effect
    if entry.words:
        effect = effect_of(entry, dataset)
    else:  # the flexible term that a diagnosis would add
        effect = UnattributedJoint(3, (Variable.observed("q3", dataset.q[:, 2]),))
    model, prepared = geometry_fit(dataset)
    state = refit(dataset, model, prepared.free, (effect,))
    calibration = conclude(dataset, prepared, *fit_from(dataset, state.model, state.free))
    view = FittedView.of(state, calibration.free, calibration.covariance)
    return state.effects[0].pictures(view)


def draw(picture: Profile | Map) -> Figure:
    """Return a figure with two panels: without and with the effect in the model."""
    with styled():
        figure = Figure(figsize=(8.4, 3.2), layout="constrained")
        axes = figure.subplots(1, 2, sharex=True, sharey=True)
        for ax, values, title in zip(
            axes, (picture.y, picture.rest), ("effect left out", "effect in the model"), strict=True
        ):
            (_map if isinstance(picture, Map) else _profile)(ax, picture, values, values is picture.y)
            ax.set_title(title, fontsize=9)
    return figure


def _clearest(pictures: list[Profile | Map]) -> Profile | Map:
    """Return the picture in which the effect is largest beside its noise; of several, the last."""

    def clarity(picture: Any) -> float:
        return 0.0 if isinstance(picture, Map) else float(np.std(picture.fitted) / np.nanmedian(picture.std))

    return max(reversed(pictures), key=clarity)


def _profile(ax: Axes, picture: Any, values: Any, fitted: bool) -> None:
    x, y = shown(picture.x_axis, picture.x), shown(picture.y_axis, values)
    sure = picture.std <= 3 * np.nanmedian(picture.std)
    ax.plot(x[sure], y[sure], ".", color=DOT, markersize=3, alpha=0.7)
    if fitted and picture.curve is not None:
        ax.plot(
            shown(picture.x_axis, picture.curve[0]), shown(picture.y_axis, picture.curve[1]), color=ORANGE
        )
    elif fitted:
        says = shown(picture.y_axis, picture.fitted)
        ax.plot(x[sure], says[sure], "s", color=ORANGE, markersize=3, markerfacecolor="none")
    if picture.mark is not None:
        ax.axvline(picture.mark, color="black", linestyle=":", linewidth=1)
    both = [shown(picture.y_axis, part[sure]) for part in (picture.y, picture.rest)]
    ax.set_ylim(*range_of(both, _SHOWN))
    ax.set_xlabel(in_words(picture.x_axis))
    if fitted:
        ax.set_ylabel(in_words(picture.y_axis))


def _map(ax: Axes, picture: Any, values: Any, first: bool) -> None:
    u, v = shown(picture.u_axis, picture.u), shown(picture.v_axis, picture.v)
    y, largest = shown(picture.y_axis, values), np.nanquantile(np.abs(picture.y), _COLOUR_SCALE)
    limit = float(shown(picture.y_axis, np.array([largest]))[0])
    drawn = ax.scatter(u, v, c=y, s=7, cmap="RdBu_r", vmin=-limit, vmax=limit)
    ax.set_xlabel(in_words(picture.u_axis))
    if first:
        ax.set_ylabel(in_words(picture.v_axis))
    else:
        ax.figure.colorbar(drawn, ax=ax, label=in_words(picture.y_axis))


def main(names: list[str]) -> None:
    """Draw the effects with these names, or all."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in [*CATALOGUE, *NOISES]:
        if not names or name in names:
            path = PICTURES / f"{name}.png"
            figure = (
                noise_figure(name) if name in NOISES else draw(_clearest(pictures_of(name, CATALOGUE[name])))
            )
            save_figure(figure, [path])
            with Image.open(path) as image:  # a third of the size
                image.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
            print(name, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
