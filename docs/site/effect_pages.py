"""A page for each effect of the registry: what it is, its cause and remedy, how to inject it, and its picture."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

import numpy as np
from ruamel.yaml import YAML

from docs.site.catalogue import CATALOGUE, SCENE, Shown, effect_of
from scalar.data.dataset import Dataset
from scalar.effects.effect import Effect
from scalar.effects.flexible.first_steps import first_steps
from scalar.effects.registry import BUILT_IN
from scalar.effects.wording import sized

PICTURES = Path(__file__).resolve().parents[1] / "pictures/effects"
NOISES = {
    "pose_jitter": "Each pose repeats only to a spread in the joints. This is a random error and is reported as a standard deviation [rad].",
    "scan_bias": "Each scan has an error of its own, common to its points. It is reported as a standard deviation [m].",
}


def write_pages(folder: Path, dataset: Dataset) -> None:
    """Write a page for every effect.

    Args:
        folder: To write to.
        dataset: Of the scene of the pages, whose joints and planes words and advice name.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for kind in BUILT_IN:
        (folder / f"{kind.name}.md").write_text(_page(kind, CATALOGUE[kind.name], dataset), encoding="utf-8")


def write_table(path: Path) -> None:
    """Write the table of all effects, with links to their pages in the folder ``effects`` beside it, for a page of the folder above."""
    rows = "".join(
        f"| [{kind.name}](generated/effects/{kind.name}.md) | {kind.sentence} |\n" for kind in BUILT_IN
    )
    noises = "".join(f"| `{name}` | {text} |\n" for name, text in NOISES.items())
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        f"""| effect | what it is |
| --- | --- |
{rows}
Two more are random errors. They are reported only if the residuals show no significant autocorrelation, and they are not corrected:

| noise | what it is |
| --- | --- |
{noises}""",
        encoding="utf-8",
    )


def _page(kind: type[Effect], shown: Shown, dataset: Dataset) -> str:
    example = effect_of(shown, dataset) if shown.words else None
    advice = first_steps(["q3"]) if example is None else example.advice
    parts = [
        f"# {kind.name}",
        f"{_sentence(kind.sentence)}.",
        _picture(kind.name),
        "## The model",
        _docstring(kind),
        _sizes(kind, example),
        "## What to do about it",
        _list(advice)
        or "Its correction is in `after.json`; the diagnosis has no advice on the hardware for it.",
        *(_observability(kind, dataset)),
        "## How to inject it",
        _injection(shown),
        "## How to ask for it",
        _command(shown, kind),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _sentence(clause: str) -> str:
    return clause[:1].upper() + clause[1:]


def _list(lines: Sequence[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)


def _picture(name: str) -> str:
    path = PICTURES / f"{name}.png"
    if not path.exists():
        return ""
    return (
        f"![{name} in simulated data: left without the effect in the model, right with it](../../pictures/effects/{name}.png)\n\n"
        f"*A simulated workcell with {name}. Left: what each measurement shows if the effect is left out of the model (dots), and the fitted effect "
        "(line or squares). Right: what remains with the effect in the model.*"
    )


def _docstring(kind: type[Effect]) -> str:
    """Return the class's own docstring without its attributes: the equation and its source."""
    return inspect.cleandoc(kind.__doc__ or "").partition("\n\nAttributes:")[0].replace("``", "`")


def _sizes(kind: type[Effect], example: Effect | None) -> str:
    if example is None:
        return ""
    units = ", ".join(f"`{name}`" for name in dict.fromkeys(_shortened(example.coefficient_names)))
    text = f"Its coefficients are {units}."
    sizes = [
        sized(float(size), unit)
        for size, unit in zip(example.natural_sizes, example.coefficient_units, strict=True)
        if size and np.isfinite(size)
    ]
    if sizes:
        text += f" In real workcells they are of the size of {', '.join(dict.fromkeys(sizes))}"
        text += f" ({kind.natural_source})." if kind.natural_source else "."
    return text


def _shortened(names: Sequence[str], most: int = 6) -> list[str]:
    return [*names] if len(names) <= most else [*names[: most - 1], "and others"]


def _observability(kind: type[Effect], dataset: Dataset) -> list[str]:
    lines = [*([kind.remedy_advice] if kind.remedy_advice else []), *kind.advice_on_data(dataset)]
    return ["## What makes it observable", _list(lines)] if lines else []


def _injection(shown: Shown) -> str:
    yaml, changes = YAML(), StringIO()
    yaml.default_flow_style = None
    yaml.dump(shown.changes, changes)
    return (
        f"In a copy of a scene such as `{SCENE}`, write:\n\n```yaml\n{changes.getvalue()}```\n\n"
        "`scalar simulate SCENE.yaml -o sim` then writes the dataset to `sim/dataset`, and what was injected to `sim/truth`. "
        f"{shown.note}"
    ).rstrip()


def _command(shown: Shown, kind: type[Effect]) -> str:
    if not shown.words:
        return "It cannot be asked for by name; `scalar diagnose` adds it where no named effect explains the residual."
    return (
        "`scalar diagnose` tries it by itself. To estimate it whatever the data say:\n\n"
        f"```sh\nscalar calibrate my-cell -o out --effects {shown.words}\n```"
    )
