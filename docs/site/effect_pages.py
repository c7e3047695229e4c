"""A page for each effect of the registry: what it is, its cause and remedy, how to inject it, and its picture."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

import numpy as np
from ruamel.yaml import YAML

from docs.site.catalogue import CATALOGUE, NOISES, SCENE, Shown, effect_of
from docs.site.noise_words import NOISE_WORDS, NoiseWords
from scalar.data.dataset import Dataset
from scalar.effects.effect import Effect
from scalar.effects.flexible.first_steps import first_steps
from scalar.effects.registry import BUILT_IN
from scalar.effects.wording import sized

PICTURES = Path(__file__).resolve().parents[1] / "pictures/effects"


def write_pages(folder: Path, dataset: Dataset) -> None:
    """Write a page for every effect, and for each of the two random errors.

    Args:
        folder: To write to.
        dataset: Of the scene of the pages, whose joints and planes words and advice name.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for kind in BUILT_IN:
        (folder / f"{kind.name}.md").write_text(_page(kind, CATALOGUE[kind.name], dataset), encoding="utf-8")
    write_noise_pages(folder)


def write_noise_pages(folder: Path) -> None:
    """Write a page for each of the two random errors to a folder that exists."""
    for name, noise_words in NOISE_WORDS.items():
        (folder / f"{name}.md").write_text(_noise_page(name, noise_words), encoding="utf-8")


def write_table(path: Path) -> None:
    """Write the table of all effects, with links to their pages in the folder ``effects`` beside it, for a page of the folder above."""
    rows = "".join(
        f"| [{kind.name}](generated/effects/{kind.name}.md) | {kind.sentence} |\n" for kind in BUILT_IN
    )
    noises = "".join(
        f"| [{name}](generated/effects/{name}.md) | {noise_words.sentence} |\n"
        for name, noise_words in NOISE_WORDS.items()
    )
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


def _noise_page(name: str, said: NoiseWords) -> str:
    """Return the page of a random error: it is reported and never corrected, so there is no command that frees it."""
    parts = [
        f"# {name}",
        said.sentence,
        f"![{name} in simulated data: left by the noise within scans alone, right with the component](../../pictures/effects/{name}.png)",
        f"*A simulated workcell with {name}: the residual of each scan, in standard deviations of the noise that the model expects, "
        "over what a jitter of 0.01° in every joint would add to it. Left: the noise within scans alone. Right: with the random error that "
        "was found. Where the noise explains the scans, the shaded band holds 95 % of them, and the orange dots bound 95 % if the random "
        f"error is counted as well. {said.in_picture}*",
        "## The model",
        said.model,
        "## Where it comes from",
        said.cause,
        "## How sure its name is",
        said.how_sure,
        "## What to do about it",
        _list(said.advice),
        "## How to inject it",
        _injection(NOISES[name]),
        "## How to ask for it",
        "It cannot be asked for by name, because a random error is nothing that a calibration corrects. `scalar diagnose` looks for it by itself; "
        "`calibration.json` lists it under `noise`, and `diagnosis.json` under `effects`.",
    ]
    return "\n\n".join(parts) + "\n"


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
