"""``scalar evaluate``: compare a calibration with the truth of a simulated dataset."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.group import cli
from scalar.cli.options import OUTPUT, PATH, lock_output
from scalar.cli.outputs import FORCE, json_of, refuse_foreign
from scalar.cli.terminal import say

if TYPE_CHECKING:
    from scalar.evaluate import Evaluation


@cli.command()
@click.argument("calibration", type=PATH)
@click.argument("truth", type=PATH)
@OUTPUT
@FORCE
def evaluate(calibration: Path, truth: Path, output: Path, force: bool) -> None:
    """Compare a calibration with a simulated truth.

    The errors are taken over the poses of the truth. Writes DIR/evaluation.json and prints a summary.

    TRUTH is the folder `truth` of a simulated dataset, or one of your own with a table truth_poses.csv: pose,q1..qn [rad; m where a joint slides] as
    the encoders read them, and the true frame x,y,z [m], rx,ry,rz [rotation vector in rad] of the sensor in that of the base; with the columns of
    poses.csv that the calibrated effects need.

    \b
    Example:
      scalar evaluate out/calibration.json sim/truth -o out
    """
    from scalar.data.io.atomic import write_json
    from scalar.estimation.result import load_calibration
    from scalar.evaluate import evaluate
    from scalar.evaluate.truth import read_truth, refuse_truth_of_another_robot

    refuse_foreign([(output / "evaluation.json", json_of("evaluation"))], force)
    lock_output(output)
    model = load_calibration(calibration)
    robot = model.model.robot
    truth_poses, content = read_truth(truth, robot.n_joints, robot.limits, robot.prismatic)
    result = evaluate(model, truth_poses, content)
    refuse_truth_of_another_robot(truth, content, model.model.nominal, float(result.aligned.position.mean()))
    write_json(output / "evaluation.json", result.to_mapping())
    say(describe_evaluation(result))
    named = None if content is None else content.get("robot")
    if named and named != robot.name:
        say(
            f"  note: the truth calls the robot '{named}', and the calibration '{robot.name}': do they belong together?"
        )
    say(f"written: {output / 'evaluation.json'}")


def describe_evaluation(evaluation: Evaluation) -> str:
    """Return the errors against the truth, raw and aligned."""
    lines = [
        f"errors over {len(evaluation.raw.position)} poses   position mean / max [mm]   orientation mean / max [deg]"
    ]
    for name, errors in (("raw", evaluation.raw), ("aligned", evaluation.aligned)):
        e = errors.to_mapping()
        lines.append(
            f"  {name:<8} {e['position_mean_mm']:18.4f} / {e['position_max_mm']:.4f}"
            f" {e['orientation_mean_deg']:18.5f} / {e['orientation_max_deg']:.5f}"
        )
    if not evaluation.planes.empty:
        worst = evaluation.planes.loc[evaluation.planes["normal_error_deg"].idxmax()]
        largest = evaluation.planes["distance_error_mm"].abs().max()
        lines.append(
            f"  planes (raw): distance within {largest:.4f} mm, "
            f"normal within {worst['normal_error_deg']:.5f} deg"
        )
    return "\n".join(lines)
