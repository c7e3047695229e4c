"""The command line, thin: read, call one function, write, say what was found. Faults go to stderr, a line each, and set the exit status."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from scalar import __version__
from scalar.errors import Fault, InvalidInput, ScalarError

# Small matrices lose time, and reproducible bytes, to threads. Set before NumPy is first imported, which every command does for itself.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

_FOLDER = click.Path(path_type=Path)
_OUTPUT = click.option(
    "-o", "--output", "output", type=_FOLDER, required=True, help="Folder to write to; made if missing."
)


class _Group(click.Group):
    """A group that turns the package's own errors into lines on stderr and an exit status."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except ScalarError as error:
            for line in str(error).splitlines() or [type(error).__name__]:
                click.echo(f"scalar: {line}", err=True)
            ctx.exit(error.exit_status)
        except OSError as error:
            click.echo(f"scalar: {error.filename or 'output'}: {error.strerror or error}", err=True)
            ctx.exit(2)


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="scalar")
def cli() -> None:
    """Calibrate a robot and the sensor on its flange together, from scans of three rough planes.

    \b
    Your own data in four lines:
      scalar validate my-cell
      scalar calibrate my-cell -o out
      scalar predict out/calibration.json joints.csv -o frames.csv
      scalar diagnose my-cell -o out          # what does the model lack?

    Exit status: 0 done; 2 the input is at fault; 3 the data cannot determine the model.
    """


@cli.command()
@click.argument("config", type=_FOLDER)
@_OUTPUT
@click.option("--seed", type=click.IntRange(min=0), help="Instead of the seed in CONFIG.")
def simulate(config: Path, output: Path, seed: int | None) -> None:
    """Simulate a dataset with pybullet, as CONFIG says: DIR/dataset, and its truth in DIR/truth.

    \b
    Example:
      scalar simulate configs/scenes/paper.yaml -o sim
      scalar calibrate sim/dataset -o out
      scalar evaluate out/calibration.json sim/truth -o out
    """
    from scalar.cli.terminal import progress

    try:
        from scalar.simulation import load_config, simulate, write_scene
    except ModuleNotFoundError as error:
        if error.name != "pybullet":
            raise
        raise click.ClickException(
            "simulating needs pybullet: pip install 'scalar-calibration[simulation]'"
        ) from None
    content = load_config(config)
    if seed is not None:
        content["seed"] = seed
    with progress("placing the scanner") as advance:
        scene = simulate(content, base_dir=config.parent, progress=advance)
    write_scene(scene, output)
    click.echo(
        f"{output / 'dataset'}: {len(scene.poses)} poses, {len(scene.scans)} points; truth in {output / 'truth'}"
    )


@cli.command("import")
@click.argument("mapping", type=_FOLDER)
@click.argument("sources", metavar="SOURCE...", type=_FOLDER, nargs=-1, required=True)
@click.option("-o", "--output", "output", type=_FOLDER, required=True, help="Dataset folder to write.")
def import_(mapping: Path, sources: Sequence[Path], output: Path) -> None:
    """Bring tables with other columns, units and separators into a dataset, as the YAML file MAPPING says.

    A SOURCE is a CSV file, a MATLAB matrix (.mat), or a folder that holds the files that MAPPING names.

    \b
    Example (see configs/measured for complete mappings):
      scalar import my-tracker.yaml measurements.csv -o my-cell
      scalar diagnose my-cell -o out
    """
    from scalar.cli.terminal import describe_dataset
    from scalar.data.dataset import read_dataset
    from scalar.ingest.convert import import_dataset

    import_dataset(mapping, sources, output)
    click.echo(describe_dataset(read_dataset(output)))
    click.echo(f"written: {output}")


@cli.command()
@click.argument("dataset", type=_FOLDER)
def validate(dataset: Path) -> None:
    """Check a dataset: say what it holds, and every fault that is found, one a line.

    \b
    Example:
      scalar validate my-cell
    """
    from scalar.cli.terminal import describe_dataset
    from scalar.data.dataset import read_dataset

    click.echo(describe_dataset(read_dataset(dataset)))


@cli.command()
@click.argument("dataset", type=_FOLDER)
@_OUTPUT
@click.option(
    "--effects",
    "effects",
    metavar="NAME,...",
    help="Free these effects as well, e.g. joint_compliance,joint_scale:2.",
)
@click.option(
    "--effects-from",
    type=_FOLDER,
    metavar="CALIBRATION",
    help="Take the arm's effects from another calibration and hold them.",
)
@click.option(
    "--hold", metavar="NAME,...", help="Hold these parameters at their nominal values, e.g. a_2,d_4."
)
def calibrate(
    dataset: Path, output: Path, effects: str | None, effects_from: Path | None, hold: str | None
) -> None:
    """Calibrate robot, sensor and planes together: DIR/calibration.json and a summary.

    \b
    Examples:
      scalar calibrate my-cell -o out
      scalar calibrate my-cell -o out --effects joint_compliance
      scalar calibrate later -o out2 --effects-from out/calibration.json
    """
    from scalar.cli.terminal import describe_calibration, progress
    from scalar.data.dataset import read_dataset
    from scalar.effects.catalogue import parse_effects
    from scalar.effects.transfer import carried
    from scalar.estimation.calibrate import calibrate
    from scalar.estimation.result import load_calibration

    data = read_dataset(dataset)
    wanted = parse_effects(effects, data) if effects else ()
    given = carried(load_calibration(effects_from).model, data) if effects_from else None
    with progress("calibrating"):
        result = calibrate(
            data, effects=wanted, held_effects=given.effects if given else (), hold=_listed(hold)
        )
    if given:
        result = replace(result, summary={**result.summary, "effects_from": given.to_mapping()})
    result.save(_made(output) / "calibration.json")
    click.echo(describe_calibration(result))
    click.echo(f"written: {output / 'calibration.json'}")


@cli.command()
@click.argument("dataset", type=_FOLDER)
@_OUTPUT
def diagnose(dataset: Path, output: Path) -> None:
    """Find what the model lacks, add it, and compare errors before and after on held-out poses.

    Writes DIR/before.json and DIR/after.json (calibrations), DIR/diagnosis.json and DIR/report.html (one file, opens offline).

    \b
    Example:
      scalar diagnose my-cell -o out
      scalar predict out/after.json joints.csv -o frames.csv
    """
    from scalar.cli.terminal import describe_diagnosis, stages
    from scalar.data.dataset import read_dataset
    from scalar.diagnosis import diagnose, write_diagnosis

    data = read_dataset(dataset)
    with stages() as advance:
        result = diagnose(data, progress=advance)
        advance("writing the report")
        write_diagnosis(result, _made(output))
    click.echo(describe_diagnosis(result))
    click.echo(f"written: {output / 'report.html'}, diagnosis.json, before.json, after.json")


@cli.command()
@click.argument("calibration", type=_FOLDER)
@click.argument("joints", type=_FOLDER)
@click.option("-o", "--output", type=_FOLDER, required=True, help="CSV file to write.")
def predict(calibration: Path, joints: Path, output: Path) -> None:
    """Predict the sensor's frame in the base frame for every row of JOINTS.csv, all calibrated effects applied.

    JOINTS.csv has pose,q1..qn [rad] and the optional columns of poses.csv. Written: pose,x,y,z,rx,ry,rz [m, rotation vector rad].

    \b
    Example:
      scalar predict out/calibration.json joints.csv -o frames.csv
    """
    from scalar.data.pose_tables import read_pose_table
    from scalar.estimation.frame_tables import write_frames
    from scalar.estimation.result import load_calibration

    model = load_calibration(calibration)
    robot = model.model.robot
    table = read_pose_table(joints, robot.n_joints, limits=robot.limits)
    write_frames(output, table["pose"].to_numpy(), model.predict(table))
    click.echo(f"written: {output}, {len(table)} poses")


@cli.command()
@click.argument("calibration", type=_FOLDER)
@click.argument("truth", type=_FOLDER)
@_OUTPUT
def evaluate(calibration: Path, truth: Path, output: Path) -> None:
    """Compare a calibration with a simulated truth over its poses: DIR/evaluation.json and a summary.

    \b
    Example:
      scalar evaluate out/calibration.json sim/truth -o out
    """
    from scalar.cli.terminal import describe_evaluation
    from scalar.data.io.atomic import write_json
    from scalar.estimation.frame_tables import read_truth
    from scalar.estimation.result import load_calibration
    from scalar.evaluate import evaluate

    model = load_calibration(calibration)
    robot = model.model.robot
    truth_poses, content = read_truth(truth, robot.n_joints, robot.limits)
    result = evaluate(model, truth_poses, content)
    write_json(_made(output) / "evaluation.json", result.to_mapping())
    click.echo(describe_evaluation(result))
    click.echo(f"written: {output / 'evaluation.json'}")


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"cannot be written ({error.strerror or error}); give another place for the output"
        raise InvalidInput(Fault(str(folder), message)) from None
    return folder


def _listed(names: str | None) -> Sequence[str]:
    return [name.strip() for name in names.split(",") if name.strip()] if names else ()


def main() -> None:
    """Run the command line."""
    cli(prog_name="scalar")


if __name__ == "__main__":
    sys.exit(main())
