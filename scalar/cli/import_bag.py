"""``scalar import-bag``: make a dataset from a recorded ROS bag."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.group import cli
from scalar.cli.options import PATH, split_names
from scalar.cli.outputs import FORCE
from scalar.cli.progress import progress
from scalar.cli.terminal import say
from scalar.cli.validate import describe_content
from scalar.errors import Fault, InvalidInput
from scalar.ingest.bag import LEAST_TIME, SETTLED, STILL

if TYPE_CHECKING:
    from scalar.ingest.bag.losses import StopCounts


@cli.command("import-bag")
@click.argument("workcell", type=PATH)
@click.argument("bag", type=PATH)
@click.option("-o", "--output", "output", type=PATH, required=True, help="Dataset folder to write.")
@click.option(
    "--joints",
    "joint_topic",
    metavar="TOPIC",
    help="Topic of the JointState messages; the only one if not given.",
)
@click.option(
    "--scans",
    "scan_topic",
    metavar="TOPIC",
    help="Topic of the LaserScan or PointCloud2 messages; the only one if not given.",
)
@click.option(
    "--joint-names",
    metavar="NAME,...",
    help="Names of the recorded joints in the order of q1..qn; if not given, those in WORKCELL, else the order of recording.",
)
@click.option(
    "--still",
    type=float,
    default=STILL,
    show_default=True,
    help="Range within which a joint counts as standing still [rad; m for a slide].",
)
@click.option(
    "--settled",
    type=float,
    default=SETTLED,
    show_default=True,
    help="Time after each motion during which data are left out [s].",
)
@click.option(
    "--least",
    type=float,
    default=LEAST_TIME,
    show_default=True,
    help="Least time for which the arm has to stand still after that [s].",
)
@click.option(
    "--degrees", is_flag=True, help="The recorded joint positions are in degrees; JointState has radians."
)
@click.option(
    "--accept-losses",
    is_flag=True,
    help="Write the dataset even if most stops have to be left out, or the recording fits another reading of the set-up far better.",
)
@FORCE
def import_bag(
    workcell: Path,
    bag: Path,
    output: Path,
    joint_topic: str | None,
    scan_topic: str | None,
    joint_names: str | None,
    still: float,
    settled: float,
    least: float,
    degrees: bool,
    accept_losses: bool,
    force: bool,
) -> None:
    """Import a ROS bag into a dataset.

    WORKCELL is a dataset.yaml (or the folder that holds it, as `scalar init` makes it) with the robot, the approximate pose of the scanner on
    the flange, and initial guesses of the planes. BAG is a .bag file of ROS 1, or a folder or file (.mcap, .db3) of ROS 2, with JointState
    and LaserScan or PointCloud2 messages. ROS need not be installed.

    The arm has to stop at every pose for half a second or more. Of each stop the scan in the middle is taken, cut to its longest straight
    piece, and labelled with the plane on which it lies; scans near no plane, or near two, are left out and counted. If more than half
    of the stops would be left out, nothing is written (exit status 3), and the message states the main reason and what to try. Often the reason is
    that the joints are recorded in another order, with another sign or zero, that the scanner's axes have other directions, or that the guess of a
    plane is far off: if the scans lie on the planes far better with one such correction, nothing is written either, and the message names it.

    \b
    Example:
      scalar import-bag my-cell campaign.bag -o measured
      scalar diagnose measured -o out
    """
    for name, value in (("--still", still), ("--settled", settled), ("--least", least)):
        if not 0.0 <= value < math.inf or (value == 0.0 and name != "--settled"):
            raise InvalidInput(
                Fault(name, f"{value:g} is not greater than 0; write a time or an angle, or leave it out")
            )
    from scalar.data.dataset_writer import refuse_dataset
    from scalar.data.folder import read_folder
    from scalar.ingest.bag.messages import read_bag
    from scalar.ingest.bag.to_dataset import BagSettings, load_workcell, write_recorded_dataset

    refuse_dataset(output, force)
    content = load_workcell(workcell)
    with progress("reading the recording"):
        recording = read_bag(bag, joint_topic, scan_topic)
    settings = BagSettings(
        tuple(split_names(joint_names)), still, settled, least, accept_losses, force, degrees
    )
    with progress("finding the planes of the scans") as advance:
        counts = write_recorded_dataset(
            recording,
            content,
            settings,
            output,
            lambda done, total: advance("trying other readings of the set-up", done, total),
        )
    say(f"  joints q1..qn: {', '.join(counts.joint_names)}")
    for line in _left_out(counts):
        say(line)
    say(describe_content(read_folder(output)))
    say(f"written: {output}")


def _left_out(counts: StopCounts) -> list[str]:
    """Return the number of stops, and how many were left out for each reason, one line each."""
    lines = [f"  {counts.still} stops"]
    lines += [f"  left out: {count}, {why}" for why, count in counts.reasons.items()]
    return lines
