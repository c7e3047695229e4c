"""`scalar plan` without `--after`: choose the poses from which predictions are expected to be best, and report the expected errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.cli.plan_files import ChosenPoses
from scalar.errors import Fault, InvalidInput
from scalar.planning.defaults import PLANNED_POSES
from scalar.planning.information import information
from scalar.planning.plan import choose_poses, error_of, least_poses, poses_for_error
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.planning.candidates import Candidates
    from scalar.planning.information import Information
    from scalar.planning.plan import Plan
    from scalar.planning.workcell import Workcell

_CURVE = (20, 30, 40, 60, 80, 120)  # numbers of poses for which the expected error is stated


def plan_by_error(
    workcell: Workcell,
    found: Candidates,
    dataset: Dataset | None,
    poses: int | None,
    accuracy: float | None,
    criterion: str,
    seed: int,
) -> ChosenPoses:
    """Return the poses from which predictions are expected to be best.

    Args:
        workcell: The arm, its sensor and its target.
        found: The candidate poses.
        dataset: The poses that were measured before, to which the plan adds; None if there are none.
        poses: Number of poses to plan; None for the number that ``accuracy`` requires, or else for ``PLANNED_POSES``.
        accuracy: Wanted error of predicted positions [mm], root mean square over the workspace, or None.
        criterion: As in ``choose_poses``.
        seed: Seed of the random sets with which the search begins, and with which the plan is compared.

    Raises:
        InvalidInput: The measured poses reach the wanted error already, or there are too few poses or candidates.
    """
    measured = None if dataset is None else replace(dataset, sensor=workcell.sensor, planes=workcell.planes)
    candidates = workcell.dataset(found.q, found.plane)
    info = information(workcell.model, candidates, workcell.repeatability, measured)
    least = least_poses(info, workcell.equations_per_pose)
    lines: list[str] = []
    if accuracy is not None:
        enough, lines = _poses_for_accuracy(info, accuracy, poses, least, criterion)
        poses = poses or enough
    count = poses or PLANNED_POSES
    _check_count(info, count, least)
    rng = np.random.default_rng(seed)
    result = choose_poses(info, count, criterion, rng, tuple(n for n in _CURVE if n >= least))
    parts = _errors_of_parts(workcell, info, result)
    lines = [
        *_lines_on_error(workcell, info, result, parts),
        *lines,
        _line_on_other_counts(info, result, count),
        *_line_on_diagnosis(info, count, workcell.equations_per_pose),
    ]
    content = {**result.to_mapping(), **parts, "not_determined": list(info.fixed)}
    return ChosenPoses(result.chosen, content, lines, result.curve, (len(result.chosen), result.random_error))


def _more(info: Information) -> str:
    """Return the word before "poses" if poses were measured already."""
    return "more " if info.measured else ""


def _poses_for_accuracy(
    info: Information, accuracy: float, poses: int | None, least: int, criterion: str
) -> tuple[int | None, list[str]]:
    """Return how many poses a wanted error takes (None if it takes too many), and the line that says so.

    Args:
        info: What the candidates tell.
        accuracy: The wanted error [mm].
        poses: Number of poses that is planned in any case, or None.
        least: Least number of poses of a calibration.
        criterion: As in ``choose_poses``.

    Raises:
        InvalidInput: The measured poses reach the wanted error already.
    """
    now = error_of(info, []) if info.measured else np.inf
    if now <= accuracy * MM and poses is None:
        message = f"the {info.measured} measured poses are expected to leave {now / MM:.4f} mm already; for more poses nevertheless, give --poses"
        raise InvalidInput(Fault("--accuracy", message))
    enough, (most, left) = poses_for_error(info, accuracy * MM, least, criterion)
    if enough is not None:
        return enough, [f"  an error of {accuracy:g} mm takes {enough} {_more(info)}poses"]
    return None, [
        f"  an error of {accuracy:g} mm takes more than {most} {_more(info)}poses; with {most} the expected error is {left / MM:.4f} mm. "
        "A better sensor or a more repeatable arm would help"
    ]


def _check_count(info: Information, count: int, least: int) -> None:
    """Refuse a number of poses that cannot be planned.

    Raises:
        InvalidInput: They are fewer than ``least``, or more than the candidates.
    """
    if count < least:
        together = f" together with the {info.measured} measured ones" if info.measured else ""
        message = (
            f"{count} poses{together} cannot determine {len(info.free)} parameters; plan at least {least}"
        )
        raise InvalidInput(Fault("--poses", message))
    if count > len(info.rows):
        raise InvalidInput(
            Fault("--poses", f"more than the {len(info.rows)} candidates; give more --candidates")
        )


def _lines_on_error(
    workcell: Workcell, info: Information, result: Plan, parts: Mapping[str, Any]
) -> list[str]:
    """Return the lines on the expected error: of the plan, of its parts (as ``_errors_of_parts`` returns them), and of random poses."""
    together = f" together with the {info.measured} measured poses," if info.measured else ""
    lines = [
        f"  expected error of predicted positions:{together} {result.error / MM:.4f} mm RMS within the joint limits, "
        f"from noise of {workcell.noise / MM:.3g} mm and repeatability of {workcell.repeatability / MM:g} mm alone"
    ]
    if parts:
        planned = parts["expected_error_of_planned_poses_alone_mm"]
        alone = (
            "the planned ones alone are too few for a calibration"
            if planned is None
            else f"the planned ones alone {planned:.4f} mm"
        )
        lines.append(
            f"  the measured poses alone: {parts['expected_error_of_measured_poses_mm']:.4f} mm; {alone}. "
            "The error of both together holds only if base, sensor and target have not moved since"
        )
    return [*lines, f"  as many {_more(info)}poses drawn at random: {result.random_error / MM:.4f} mm"]


def _line_on_other_counts(info: Information, result: Plan, count: int) -> str:
    """Return the line on the errors that are expected with other numbers of poses than ``count``."""
    others = ", ".join(f"{n}: {e / MM:.4f}" for n, e in result.curve if n != count)
    return f"  with other numbers of {_more(info)}poses, the expected error is at most [mm]: {others}"


def _line_on_diagnosis(info: Information, count: int, equations_per_pose: int) -> list[str]:
    """Return a line if the measured and the planned poses together are fewer than a diagnosis needs, which the expected error does not show."""
    from scalar.diagnosis.naming.two_halves import EQUATIONS_FOR_EFFECTS

    needed = int(np.ceil(EQUATIONS_FOR_EFFECTS * len(info.free) / equations_per_pose))
    missing = needed - count - info.measured
    if missing <= 0:
        return []
    return [
        f"  enough for a calibration of the geometry; for a diagnosis of what the model lacks (`scalar diagnose`), plan {missing} poses more "
        f"({needed} in all)"
    ]


def _errors_of_parts(workcell: Workcell, info: Information, result: Plan) -> dict[str, Any]:
    """Return the entries of ``plan.json`` on the measured poses alone and on the planned poses alone; none if no poses were measured."""
    if not info.measured:
        return {}
    alone = info.alone()
    enough = len(result.chosen) >= least_poses(alone, workcell.equations_per_pose)
    return {
        "measured_poses": info.measured,
        "expected_error_of_measured_poses_mm": error_of(info, []) / MM,
        "expected_error_of_planned_poses_alone_mm": error_of(alone, result.chosen) / MM if enough else None,
    }
