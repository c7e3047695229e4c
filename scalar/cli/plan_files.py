"""Write the files of ``scalar plan``: the poses in the order of a program, the numbers, and a picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from scalar.cli.plan_moves import in_degrees, moves_in_words
from scalar.data.dataset import Dataset
from scalar.data.io.atomic import json_text, write_together
from scalar.data.joint_convention import JointConvention
from scalar.geometry.se3 import Array
from scalar.planning.candidates import Allowed, Candidates
from scalar.planning.free_moves import order_poses
from scalar.planning.picture import draw_plan
from scalar.planning.plan import FORMAT
from scalar.planning.workcell import Workcell
from scalar.units import MM

_TOUCHING_SHOWN = 6


@dataclass(frozen=True, eq=False)
class ChosenPoses:
    """The poses of a plan, and what is reported on them.

    Attributes:
        indices: Which candidates are chosen.
        content: Entries of plan.json on how good they are.
        lines: Lines for the terminal.
        curve: Numbers of poses, each with the error [m] that is expected of it; empty if the plan is not one by its expected error.
        random: A number of poses drawn at random, and the error [m] that is expected of them; None likewise.
    """

    indices: list[int]
    content: dict[str, Any]
    lines: list[str]
    curve: list[tuple[int, float]]
    random: tuple[int, float] | None


def write_plan(
    folder: Path,
    workcell: Workcell,
    found: Candidates,
    chosen: ChosenPoses,
    allowed: Allowed | None,
    dataset: Dataset | None,
    convention: JointConvention | None = None,
) -> list[str]:
    """Write poses, numbers and picture, and return lines on the moves.

    Args:
        folder: Where to write.
        workcell: The arm, its sensor and its target.
        found: The candidate poses.
        chosen: Those of the plan.
        allowed: The test of which joint angles touch nothing, or None.
        dataset: The measured poses, from which the planned ones are numbered on; None if there are none.
        convention: How the controller counts the joints of the table in degrees; None if they count as those of the dataset.
    """
    robot = workcell.model.nominal
    q, plane = found.q[chosen.indices], found.plane[chosen.indices]
    tour, touching = order_poses(q, allowed)
    q, plane = q[tour], plane[tour]
    table = _table(workcell, q, plane, dataset)
    ids = table["pose"].tolist()
    content = {
        "format": FORMAT,
        **chosen.content,
        "robot": robot.name,
        "noise_mm": workcell.noise / MM,
        "repeatability_mm": workcell.repeatability / MM,
        "moves_that_touch_after_pose": None if allowed is None else [ids[k] for k in touching],
    }
    of_controller = table
    if convention is not None:
        joints = [f"q{i + 1}" for i in range(robot.n_joints)]
        of_controller = table.assign(**dict(zip(joints, convention.to_controller(q).T, strict=True)))
    in_degree = in_degrees(of_controller, robot.prismatic)
    files = {
        "poses.csv": table.to_csv(index=False, float_format="%.9g"),
        "poses_deg.csv": in_degree.to_csv(index=False, float_format="%.4f"),
        "plan.png": draw_plan(q, robot, chosen.curve, chosen.random),
        "plan.json": json_text(content),  # put in its place last: if it exists, the other files are complete
    }
    write_together(folder, files)
    return [f"  moves: {moves_in_words(q, robot.prismatic)}", *_lines_on_touching([ids[k] for k in touching])]


def _table(workcell: Workcell, q: Array, plane: Array, dataset: Dataset | None) -> pd.DataFrame:
    """Return the columns of a dataset's poses.csv.

    Args:
        workcell: The planes, which the poses of a plane's scanner or probe name.
        q: ``(N, n)`` [rad; m of a joint that slides], in the order of the program.
        plane: ``(N,)``, the index of each pose's plane.
        dataset: The measured poses, from which numbers and order go on (the order only where they have that column); None if there are none.
    """
    first, order = 1, 1
    if dataset is not None:
        first, order = int(dataset.pose_ids.max()) + 1, int(dataset.known_poses.order.max()) + 1
    table = pd.DataFrame(q, columns=[f"q{i + 1}" for i in range(q.shape[1])])
    table.insert(0, "pose", range(first, first + len(q)))
    if workcell.on_planes:
        table.insert(1, "plane", [workcell.planes[k].name for k in plane])
    if dataset is None or "order" in dataset.poses:
        table["order"] = range(order, order + len(q))
    return table


def _lines_on_touching(ids: list[int]) -> list[str]:
    """Return a line on the moves that touch something, given by the poses from which they start; none without such moves."""
    if not ids:
        return []
    places = ", ".join(map(str, ids[:_TOUCHING_SHOWN]))
    more = f" and {len(ids) - _TOUCHING_SHOWN} more" if len(ids) > _TOUCHING_SHOWN else ""
    if len(ids) == 1:
        return [
            f"  the move from pose {places} to the next, straight in joint angles, touches something: add a pose in between"
        ]
    return [
        f"  the moves from poses {places}{more}, each to the next and straight in joint angles, touch something: add a pose in between"
    ]
