"""``scalar diagnose``: find what the model lacks, and report it on the terminal in about ten lines."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from scalar.cli.corrected import corrected_description
from scalar.cli.group import cli
from scalar.cli.options import COMMANDED, EFFECTS_MODULE, OUTPUT, load_effects, lock_output
from scalar.cli.outputs import FORCE, is_report, json_of, refuse_foreign
from scalar.cli.terminal import say
from scalar.errors import Fault, InvalidInput

_DATASETS = click.Path(path_type=Path, readable=False)
"""Folders, readable or not: of a fleet, one that cannot be read has a line that says so, and the others are diagnosed."""


@cli.command()
@click.argument("datasets", type=_DATASETS, metavar="DATASET...", nargs=-1, required=True)
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
@click.option(
    "--cores",
    type=click.IntRange(min=1),
    help="How many processes run at once; as many as there are processors if not given. The results are the same.",
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
    cores: int | None,
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
    from scalar.cli.diagnosis_words import describe_diagnosis
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

        ctx.exit(diagnose_fleet(datasets, output, folds, effects_modules, cores))
    (dataset,) = datasets
    calibrations = [(output / name, json_of("calibration")) for name in ("before.json", "after.json")]
    others = [(output / "diagnosis.json", json_of("diagnosis")), (output / "report.html", is_report)]
    refuse_foreign([*calibrations, *others], force)
    data = read_dataset(dataset)
    data = data.commanded() if commanded else data
    with corrected_description(dataset, output), stages_and_runs() as (advance, on_fold):
        result = diagnose(data, progress=advance, outer_folds=folds, on_fold=on_fold, cores=cores)
        advance("writing the report")
        write_diagnosis(result, output)
    say(describe_diagnosis(result))
    say(f"written: {output / 'report.html'}, diagnosis.json, before.json, after.json")
