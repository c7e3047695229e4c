"""``scalar plan``: which poses to measure, in which order, and what accuracy to expect of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.convention import MAPPING, convention_of, imported_of, lines_on_convention
from scalar.cli.group import cli
from scalar.cli.options import BASE, OUTPUT, PATH, TIP, URDF, Number, lock_output
from scalar.cli.outputs import FORCE, refuse_foreign_plan
from scalar.cli.plan_source import (
    calibration_near,
    line_on_assumed_noise,
    lines_on_poses_not_counted,
    read_plan_source,
    refuse_other_than_one_robot,
    source_of_urdf,
    with_noise,
    with_place,
)
from scalar.cli.terminal import say
from scalar.data.formats import IMPORTED
from scalar.errors import Fault, InvalidInput
from scalar.planning.defaults import N_CANDIDATES, PLANNED_POSES, REPEATABILITY
from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.geometry.se3 import Array
    from scalar.planning.candidates import Allowed, Candidates
    from scalar.planning.workcell import Workcell

_NEAREST_IN_METRES = 10.0  # m; a scanner's nearest distance is less
_LEAST_NOISE = 5e-4  # mm; of no sensor


@cli.command()
@click.argument("robot", required=False)
@OUTPUT
@URDF
@BASE
@TIP
@click.option(
    "--poses", type=click.IntRange(1, 400), help=f"How many poses to plan; {PLANNED_POSES} if not given."
)
@click.option(
    "--near", type=PATH, metavar="CALIBRATION", help="Plan for the arm as it was calibrated before."
)
@click.option("--accuracy", type=Number(0, 1e6, min_open=True), metavar="MM",
              help="Say how many poses this error of predicted positions takes, and plan as many if --poses is not given.")  # fmt: skip
@click.option("--after", type=PATH, metavar="DIAGNOSIS",
              help="diagnosis.json: plan the poses that separate what it could not distinguish.")  # fmt: skip
@click.option("--criterion", type=click.Choice(["error", "determinant"]), default="error", show_default=True,
              help="What to minimise: the error of predicted positions (A-optimal), or the volume of uncertainty (D-optimal).")  # fmt: skip
@click.option("--range", "limits", default="0.10,0.45", show_default=True, metavar="NEAR,FAR",
              help="Least and largest distance that a scanner measures along a ray [m].")  # fmt: skip
@click.option(
    "--fan",
    type=Number(0, 90, min_open=True, max_open=True),
    default=15.0,
    show_default=True,
    metavar="DEG",
    help="Half of a scanner's opening angle.",
)
@click.option("--incidence", type=Number(0, 90, min_open=True), default=50.0, show_default=True, metavar="DEG",
              help="Largest angle between a scanner's ray and the normal of a plane.")  # fmt: skip
@click.option("--noise", type=Number(0, 1e3, min_open=True), metavar="MM",
              help="Noise of the sensor, 1 sigma; if not given, that of dataset.yaml, of the calibration, or 0.1.")  # fmt: skip
@click.option("--repeatability", type=Number(0, 1e3), default=REPEATABILITY / MM, show_default=True, metavar="MM",
              help="Repeatability of the arm, 1 sigma along each axis.")  # fmt: skip
@click.option("--candidates", type=click.IntRange(100, 10_000), default=N_CANDIDATES, show_default=True,
              help="How many poses to choose from.")  # fmt: skip
@click.option("--no-collisions", is_flag=True, help="Do not test for collisions, which needs pybullet.")
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the random candidates."
)
@MAPPING
@FORCE
def plan(
    robot: str | None,
    output: Path,
    urdf: Path | None,
    base: str | None,
    tip: str | None,
    poses: int | None,
    near: Path | None,
    accuracy: float | None,
    after: Path | None,
    criterion: str,
    limits: str,
    fan: float,
    incidence: float,
    noise: float | None,
    repeatability: float,
    candidates: int,
    no_collisions: bool,
    seed: int,
    mapping: Path | None,
    force: bool,
) -> None:
    """Plan which poses to measure.

    ROBOT is a dataset folder (as `scalar init` begins it) with a complete dataset.yaml, including nominal_pose of the sensor,
    or the name of an arm of the library, for which poses are then planned with a laser tracker, as they are for a URDF (--urdf instead of ROBOT).
    Candidates are drawn within the joint limits. In all of them the sensor can measure its target, neither arm nor sensor touches anything, and
    the arm does not stand in the beam of its scanner (tested by pybullet with a body of the arm that is guessed from its reach: check the moves
    before you run them). Whether a laser tracker, which stands at an unknown place, sees its target is not tested. Joints that may turn further stay
    within one turn, unless --after needs more. The plan consists of the candidates from which a calibration is expected to predict positions best.

    With --near, poses are planned for the arm as it was calibrated. Where ROBOT has measured poses, the planned ones are numbered on from
    them, they are those that add most to the measured ones, and the expected error is that of a calibration from all of them. It holds if base,
    sensor and planes or tracker have not moved since. The errors of the measured and of the planned poses alone are stated as well.

    With --after, poses are planned for the arm as calibrated in the after.json that lies in the folder of the diagnosis, or in what --near names.
    The plan consists of the poses that separate effects which the diagnosis could not distinguish. The output
    says for each pair of effects whether the planned poses separate them, or whether more poses would. If the diagnosis leaves
    nothing open, nothing is written. If even all candidates together separate no pair, nothing is written, and the exit status is 3.

    The expected error contains only the noise of the sensor and the repeatability of the arm: it assumes that the model lacks nothing.

    Writes DIR/poses.csv (the columns of a dataset's poses.csv, in the order of a program with short moves), DIR/plan.json
    and DIR/plan.png. Angles are in rad; DIR/poses_deg.csv has the same poses in degrees and millimetres, for the controller. With --mapping it has
    the joint angles as the controller counts them; poses.csv always has those of the dataset, to whose table its rows are appended.

    \b
    Example:
      scalar plan my-cell --poses 60 -o plan
      scalar plan my-cell --mapping my-tracker.yaml -o plan
      scalar plan ur10e --accuracy 0.05 -o plan
      scalar plan --urdf arm.urdf --base base_link --tip tool0 -o plan
      scalar plan my-cell --near out/calibration.json --poses 30 -o plan
      scalar plan my-cell --after out/diagnosis.json --poses 20 -o plan
    """
    import numpy as np

    from scalar.cli.plan_after import check_belongs, plan_after
    from scalar.cli.plan_by_error import plan_by_error
    from scalar.cli.plan_files import write_plan
    from scalar.data.folder import POSES
    from scalar.planning.candidates import draw_candidates
    from scalar.planning.workcell import View, Workcell

    refuse_foreign_plan(output, force)
    lock_output(output)
    refuse_other_than_one_robot(robot, urdf, base, tip)
    if urdf is None:
        assert robot is not None
        arm, sensor, planes, dataset = read_plan_source(
            robot, needs_data=after is not None, may_have_data=near is not None
        )
        remarks = []
    else:
        arm, sensor, remarks = source_of_urdf(urdf, base, tip, needs_data=after is not None)
        planes, dataset = (), None
    if robot is not None and dataset is not None:
        refuse_foreign_plan(output, force, [Path(robot) / POSES])
    _check_noise(noise)
    view = View(*_range(limits), fan * DEG, incidence * DEG)
    if after is not None and after.is_dir():
        after /= "diagnosis.json"
    convention = convention_of(mapping, arm)
    calibration = calibration_near(near, after, arm)
    if after is not None:
        assert dataset is not None and calibration is not None
        check_belongs(after, dataset, calibration)
    assumed = line_on_assumed_noise(sensor, noise, calibration)
    sensor = with_noise(with_place(sensor, calibration), noise, calibration)
    workcell = Workcell.of(
        arm, sensor, planes, calibration, view, repeatability * MM, same_campaign=after is not None
    )
    with _collisions(workcell, no_collisions) as (allowed, measurable):

        def draw(one_turn: bool) -> Candidates:
            return draw_candidates(
                workcell, candidates, np.random.default_rng(seed), measurable, one_turn=one_turn
            )

        if after is None:
            found = draw(True)
            chosen = plan_by_error(workcell, found, dataset, poses, accuracy, criterion, seed)
        else:
            assert dataset is not None and calibration is not None
            found, chosen = plan_after(workcell, draw, dataset, calibration, after, poses)
            if not chosen.indices:
                _refuse_earlier_plan(output, after)
                say("\n".join(chosen.lines))
                return
        lines = [*chosen.lines, *write_plan(output, workcell, found, chosen, allowed, dataset, convention)]
    imported = (robot and imported_of(robot)) or (
        {} if calibration is None else calibration.summary.get(IMPORTED, {})
    )
    lines += lines_on_convention(convention, "poses_deg.csv has", imported, arm.name)
    if robot is not None and dataset is not None:
        lines.append(_line_on_measuring(robot))
    elif robot is not None and near is None:
        lines += lines_on_poses_not_counted(robot)
    say(f"{arm.name}, {sensor.kind}: {len(chosen.indices)} poses of {len(found.q)} candidates")
    say("\n".join([*remarks, *assumed, *lines, *_lines_on_sight(workcell), *_lines_on_ends(workcell)]))
    if no_collisions:
        say("  not tested for collisions: check every pose and move before you run them")
    say(f"written: {output / 'poses.csv'}, poses_deg.csv, plan.json, plan.png")


def _line_on_measuring(dataset: str) -> str:
    """Return the line on what is done with poses that are planned for a dataset with measured poses."""
    return (
        f"  measure them, append the rows to the tables of {dataset} (pose numbers and order continue from there; give them a session of their "
        "own if base, planes or tracker were set up anew), and diagnose again"
    )


def _lines_on_sight(workcell: Workcell) -> list[str]:
    """Return a line on the line of sight to an instrument that stands elsewhere, such as a laser tracker; none if the sensor sees planes."""
    if workcell.on_planes:
        return []
    return [
        "  not tested: whether the instrument sees its target from where it stands. Leave out poses in which the arm hides the target or turns it "
        "away, and plan some more than needed"
    ]


def _lines_on_ends(workcell: Workcell) -> list[str]:
    """Return a line on the planes beside which the arm may pass; none if all go on."""
    ending = [plane.name for k, plane in enumerate(workcell.planes) if workcell.ends(k)]
    if not ending:
        return []
    return [
        f"  the arm may pass next to {' and '.join(ending)}, as extent says; what holds such a plate is not known: check poses and moves near it"
    ]


def _check_noise(noise: float | None) -> None:
    """Refuse a noise [mm] that no sensor has.

    Raises:
        InvalidInput: It is smaller than that of any sensor.
    """
    if noise is not None and noise < _LEAST_NOISE:
        message = f"no sensor has a noise of {noise:g} mm; are these metres? write millimetres"
        raise InvalidInput(Fault("--noise", message))


def _refuse_earlier_plan(output: Path, after: Path) -> None:
    """Refuse to leave an earlier plan where none is written, since a script would take it for the new one.

    Raises:
        InvalidInput: There is one.
    """
    earlier = output / "poses.csv"
    if earlier.exists():
        message = f"an earlier plan; {after} leaves nothing open that further poses would answer, and nothing is written: remove the folder"
        raise InvalidInput(Fault(str(earlier), message))


def _range(text: str) -> tuple[float, float]:
    """Return the two distances [m] of ``--range``."""
    try:
        near, far = (float(part) for part in text.split(","))
    except ValueError:
        near = far = 0.0
    if not 0 < near < far < math.inf:
        raise InvalidInput(Fault("--range", f"{text!r} is not a range; write it as 0.10,0.45 [m]"))
    if near > _NEAREST_IN_METRES:
        message = f"no scanner sees only what is {near:g} m away; are these millimetres? write metres"
        raise InvalidInput(Fault("--range", message))
    return near, far


@contextmanager
def _collisions(workcell: Workcell, without: bool) -> Iterator[tuple[Allowed | None, Allowed | None]]:
    """Yield tests by the physics engine: which joint angles touch nothing, and in which of these no part of the arm stands in the scanner's beam
    either. None for both with ``--no-collisions``."""
    if without:
        yield None, None
        return
    from scalar.cli.simulator import simulator
    from scalar.sensors import kind_named

    simulator("plan", "; or give --no-collisions")
    from scalar.geometry.robot import fixed_transform_mapping
    from scalar.simulation.collisions import collision_test

    walls = [] if workcell.touches_planes else workcell.solids()
    pose = fixed_transform_mapping(workcell.model.T_flange_sensor)
    view = workcell.view
    with collision_test(workcell.model.robot.to_mapping(), pose, walls) as tests:

        def measurable(q: Array) -> Array:
            good = tests.free(q)
            good[good] = tests.sees_past_itself(q[good], view.fan, view.far)
            return good

        yield tests.free, measurable if kind_named(workcell.sensor.kind).scans else tests.free
