"""``scalar diagnose``: find what the model lacks, and report it on the terminal in about ten lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from scalar.cli.corrected import corrected_description
from scalar.cli.group import cli
from scalar.cli.options import COMMANDED, EFFECTS_MODULE, OUTPUT, PATH, load_effects, lock_output
from scalar.cli.outputs import FORCE, is_report, json_of, refuse_foreign
from scalar.cli.terminal import say
from scalar.errors import Fault, InvalidInput

if TYPE_CHECKING:
    from scalar.diagnosis.partial_residuals import FittedView
    from scalar.diagnosis.result import Diagnosis

_UNOBSERVABLE_SHOWN = 4
_EFFECTS_NAMED = 8
_POSES_NAMED = 5  # poses set aside that are named one by one
_COEFFICIENTS_SHOWN = 3
# For terminals that show only ASCII.
_PLAIN = str.maketrans({"−": "-", "±": "+-", "°": "deg", "²": "2", "×": "x", "“": '"', "”": '"'})


@cli.command()
@click.argument("datasets", type=PATH, metavar="DATASET...", nargs=-1, required=True)
@OUTPUT
@click.option(
    "--batch",
    is_flag=True,
    help="Diagnose many datasets: those given, and all below folders that are given. A run that was stopped is continued.",
)
@click.option(
    "--quick",
    is_flag=True,
    help="Diagnose once instead of six times: findings are not confirmed, and errors on unseen poses stay unknown.",
)
@COMMANDED
@FORCE
@EFFECTS_MODULE
@click.pass_context
def diagnose(
    ctx: click.Context,
    datasets: Sequence[Path],
    output: Path,
    batch: bool,
    quick: bool,
    commanded: bool,
    force: bool,
    effects_modules: Sequence[Path],
) -> None:
    """Find what the model lacks.

    The effects that are found are added to the model. Errors before and after are compared on poses that no part of
    the diagnosis has used, unless --quick is given.

    Writes DIR/before.json and DIR/after.json (calibrations), DIR/diagnosis.json and DIR/report.html (one file, opens offline).

    With --batch, DIR has a folder of these for each dataset, and DIR/fleet.csv with one line for each dataset: what was found, the
    errors, and why a dataset was refused. Finished datasets are not computed again, unless their files or the options have changed.
    The exit status is 0, or that of the first dataset that was refused; the others are diagnosed nevertheless.

    \b
    Examples:
      scalar diagnose my-cell -o out
      scalar predict out/after.json joints.csv -o frames.csv
      scalar diagnose --batch campaigns/2026 -o fleet --quick
    """
    if len(datasets) > 1 and not batch:
        message = "more than one dataset; say --batch to diagnose all of them"
        raise InvalidInput(Fault(str(datasets[1]), message))
    if batch and commanded:
        raise InvalidInput(Fault("--commanded", "is for one dataset; leave it out, or leave out --batch"))
    from scalar.cli.progress import stages_and_runs
    from scalar.data.dataset import read_dataset
    from scalar.diagnosis import diagnose
    from scalar.diagnosis.settings import DEFAULTS
    from scalar.report.output import write_diagnosis

    lock_output(output)
    load_effects(effects_modules)
    folds = 0 if quick else DEFAULTS.hold_out.folds
    if batch:
        from scalar.cli.fleet_table import diagnose_fleet

        ctx.exit(diagnose_fleet(datasets, output, folds, effects_modules))
    (dataset,) = datasets
    calibrations = [(output / name, json_of("calibration")) for name in ("before.json", "after.json")]
    others = [(output / "diagnosis.json", json_of("diagnosis")), (output / "report.html", is_report)]
    refuse_foreign([*calibrations, *others], force)
    data = read_dataset(dataset)
    data = data.commanded() if commanded else data
    with corrected_description(dataset, output), stages_and_runs() as (advance, on_fold):
        result = diagnose(data, progress=advance, outer_folds=folds, on_fold=on_fold)
        advance("writing the report")
        write_diagnosis(result, output)
    say(describe_diagnosis(result))
    say(f"written: {output / 'report.html'}, diagnosis.json, before.json, after.json")


def describe_diagnosis(diagnosis: Diagnosis) -> str:
    """Return what was found, in about ten lines."""
    from scalar.diagnosis.partial_residuals import FittedView
    from scalar.effects.command_line import named_effects
    from scalar.effects.registry import module_of
    from scalar.estimation.misfit import lacks_something
    from scalar.report import words
    from scalar.report.excess_residual import cause_of_excess, excess_beside_findings
    from scalar.report.few_poses import few_poses
    from scalar.report.opening import verdict_on_effects
    from scalar.report.scale_words import scale_in_words, scanner_scale_in_words
    from scalar.report.shipped_words import shipped_sentences
    from scalar.report.unseen_words import unseen_sentences

    d = diagnosis.to_mapping()
    before, after = d["residual"]["before"], d["residual"]["after"]
    only_noise = diagnosis.verdict == "effect" and not diagnosis.findings
    summary = diagnosis.calibration_after.summary
    verdict = {
        "no_effect": "no effect found: "
        + (
            f"the residual is {summary['misfit']:.1f} times what the noise explains, because of {cause_of_excess(diagnosis)}"
            if lacks_something(summary)
            else "these data show nothing that the model lacks"
        ),
        "effect": "only random errors found" if only_noise else verdict_on_effects(diagnosis),
        "unattributed": "the residual holds structure that no known effect explains",
    }[d["verdict"]]
    lines = [f"{diagnosis.dataset.name}: {verdict}"]
    setup = diagnosis.calibration_before.summary["setup"]
    lines += [f"  check the set-up: {suspicion['sentence']}" for suspicion in setup]
    named = [
        k for k, finding in enumerate(diagnosis.findings) if finding.has_name
    ]  # the others share one entry
    view = FittedView.of(
        diagnosis.after, diagnosis.calibration_found.free, diagnosis.calibration_found.covariance
    )
    for i, entry in enumerate(d["effects"][:_EFFECTS_NAMED]):
        title = words.title(entry["name"], entry["target"], entry.get("depends_on", ()))
        sure = "" if entry["name"] == "unattributed" else f"; confidence {entry['confidence']:.0%}"
        many = i < len(named) and len(entry["coefficients"]) > _COEFFICIENTS_SHOWN
        size = _size_of_many(diagnosis, named[i], view) if many else ""
        sign = diagnosis.findings[named[i]].effect.sign_in_words if i < len(named) else ""
        lines.append(f"  {title}{size}{_sizes(entry, sign)}{sure}")
        lines += [
            f"    most like {words.quoted(words.title(like['name'], like['target']))}, a name with {like['confidence']:.0%} confidence"
            for like in entry.get("most_like", ())
        ]
        if entry["name"] == "unattributed":
            described = [f.effect.described_as for f in diagnosis.findings if f.effect.flexible]
            lines += [f"    described by {description}, which proves no cause" for description in described]
        if entry["confounded_with"]:
            near = [words.title(c["name"], c["target"]) for c in entry["confounded_with"]]
            more = [f"{len(near) - 3} more"] if len(near) > 3 else []
            lines.append(f"    these data do not distinguish it from {words.listed(near[:3] + more, 'or')}")
    if len(d["effects"]) > _EFFECTS_NAMED:
        lines.append(f"  and {len(d['effects']) - _EFFECTS_NAMED} more")
    if d["effects"]:
        lines.append(f"  {words.CONFIDENCE}")
    if option := named_effects(finding.effect for finding in diagnosis.findings):
        modules = {module_of(finding.effect) for finding in diagnosis.findings} - {None}
        own = "".join(f" --effects-module {module}.py" for module in sorted(map(str, modules)))
        lines.append(
            f"  --effects {option}{own} lets 'scalar calibrate' estimate these effects with all of their coefficients"
        )
    lines.append(
        f"  error on held-out poses {before['held_out_rms_mm']:.4f} -> {after['held_out_rms_mm']:.4f} mm RMS; "
        f"noise alone would leave {d['residual']['floor_mm']:.4f} mm"
    )
    sentences = [
        *excess_beside_findings(diagnosis),
        *few_poses(diagnosis),
        *unseen_sentences(diagnosis, d),
        *shipped_sentences(diagnosis),
    ]
    lines += [f"  {sentence}" for sentence in sentences]
    if scale := scale_in_words(diagnosis.calibration_after):
        lines.append(f"  no length is known in these data: every length is relative to {scale}")
    if scale := scanner_scale_in_words(diagnosis.calibration_after):
        lines.append(f"  {scale}")
    outliers = d["outliers"]
    if outliers["poses"] or outliers["points"]:
        lines.append(f"  set aside: {set_aside_in_words(outliers)}")
    if d["unobservable"]:
        titles = list(dict.fromkeys(words.title(s["name"], s["target"]) for s in d["unobservable"]))
        more = len(titles) - _UNOBSERVABLE_SHOWN
        shown = titles[:_UNOBSERVABLE_SHOWN] + ([f"{more} more (see the report)"] if more > 0 else [])
        lines.append(f"  unobservable in these data: {words.listed(shown)}")
    return "\n".join(lines).translate(_PLAIN)


def set_aside_in_words(outliers: Mapping[str, Any]) -> str:
    """Return the poses that were set aside, the first of them by their numbers, and how many points."""
    poses, mislabelled, points = outliers["poses"], outliers["mislabelled"], outliers["points"]
    parts: list[str] = []
    if poses:
        numbers = ", ".join(str(pose) for pose in poses[:_POSES_NAMED])
        more = f" and {len(poses) - _POSES_NAMED} more" if len(poses) > _POSES_NAMED else ""
        other = f" ({len(mislabelled)} on another plane than stated)" if mislabelled else ""
        parts.append(f"pose{'s' if len(poses) > 1 else ''} {numbers}{more}{other}")
    if points:
        parts.append(f"{points} point{'s' if points > 1 else ''}")
    return " and ".join(parts)


def _size_of_many(diagnosis: Diagnosis, i: int, view: FittedView) -> str:
    """Return how large finding i is in all at the measured poses, for one with many coefficients; may be empty."""
    effect = diagnosis.after.effects[i]
    size = effect.size(effect.pictures(view))
    return ", " + size.replace("°", " deg") if size else ""


def _sizes(entry: Mapping[str, Any], sign: str) -> str:
    """Return the coefficients of an effect for a line: all if there are few, else the most certain one.

    Args:
        entry: Of ``effects`` in diagnosis.json.
        sign: What the sign of the coefficients means, if they are shown without it.
    """
    from scalar.report import words

    shown = list(entry["coefficients"].items())
    if len(shown) > _COEFFICIENTS_SHOWN:
        shown = sorted(shown, key=lambda c: -abs(c[1]["value"]) / (c[1]["std"] or inf))[:1]
    rows = [words.coefficient(name, abs(c["value"]) if sign else c["value"], c["std"]) for name, c in shown]
    texts = [f"{name} {value} ± {std} {unit}" for name, value, std, unit in rows]
    if sign:
        texts[-1] += f" ({sign})"
    rest = len(entry["coefficients"]) - len(shown)
    return (": " + ", ".join(texts) if texts else "") + (f", and {rest} more coefficients" if rest else "")
