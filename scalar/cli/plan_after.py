"""``scalar plan --after``: plan the poses that separate the effects which a diagnosis could not distinguish."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scalar.cli.plan_files import ChosenPoses
from scalar.errors import Fault, InvalidInput, Undetermined
from scalar.report.pose_numbers import with_pose_numbers

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.effects import Effect
    from scalar.estimation.result import Calibration
    from scalar.geometry.se3 import Array
    from scalar.planning.candidates import Candidates
    from scalar.planning.questions import Pair
    from scalar.planning.separation import Answer
    from scalar.planning.workcell import Workcell

_FORMATS = ("scalar-diagnosis/1", "scalar-diagnosis/2")
_NOTHING = "nothing is written: no poses answer what the diagnosis left open; "
_LESS_NOISE = "a sensor with less noise, or more --candidates, would help"
_FAR = 10.0  # if the noise had to be smaller by a larger factor, no better sensor and no number of poses are suggested


def plan_after(
    workcell: Workcell,
    draw: Callable[[bool], Candidates],
    dataset: Dataset,
    calibration: Calibration,
    path: Path,
    poses: int | None,
) -> tuple[Candidates, ChosenPoses]:
    """Return candidates, the poses of them that separate the effects which a diagnosis could not distinguish, and what is reported on them.

    No candidates are chosen if the diagnosis leaves nothing open that other poses would answer.

    Args:
        workcell: The workcell near the calibration after the diagnosis.
        draw: As in ``candidates_after``.
        dataset: The dataset that was diagnosed.
        calibration: The calibration after the diagnosis.
        path: The file of the diagnosis.
        poses: Number of poses; None for the default.

    Raises:
        InvalidInput: The file is no diagnosis.
        Undetermined: The candidates answer none of the questions that it left open.
    """
    from scalar.planning.after import candidates_after, outcome
    from scalar.planning.defaults import FURTHER_POSES

    left_open = read_questions(path, calibration.model.effects, dataset)
    found, after = candidates_after(workcell, draw, dataset, calibration, left_open, poses or FURTHER_POSES)
    answers, not_by_poses = after.answers, after.not_by_poses
    lines = [f"  no poses answer this: {text}" for text in not_by_poses]
    if not after.pairs:
        return found, ChosenPoses([], {}, [*lines, *_nothing_to_plan(path, bool(lines))], [], None)
    if not any(answer.separable for answer in answers):
        raise _nothing_separable(after.pairs, answers, found, dataset, path)
    content = {
        "questions": [
            {
                "question": a.question.title,
                "standard_errors_now": a.now**0.5,
                "standard_errors_planned": a.planned**0.5,
                "standard_errors_with_all_candidates": a.limit**0.5,
                "separated": a.separated,
                "separable": a.separable,
            }
            for a in answers
        ],
        "not_answered_by_poses": not_by_poses,
        "poses": len(after.chosen),
    }
    of_answers = [
        f"  {with_pose_numbers(answer.question.title, dataset)}: {outcome(answer)}" for answer in answers
    ]
    turning = _lines_on_turns(found.q[after.chosen], workcell.model.nominal.prismatic)
    said = [*of_answers, *_lines_on_signal(answers), *lines, *turning]
    return found, ChosenPoses(after.chosen, content, said, [], None)


def _lines_on_turns(q: Array, prismatic: Sequence[int]) -> list[str]:
    """Return a line on the joints that go over more than a turn in the poses ``(k, n)`` [rad, m]; none if no joint does."""
    import numpy as np

    from scalar.report.words import listed

    named = [str(j + 1) for j in np.flatnonzero(np.ptp(q, axis=0) > 2.0 * np.pi) if j not in prismatic]
    if not named:
        return []
    joints = f"joint {named[0]} goes" if len(named) == 1 else f"joints {listed(named)} go"
    return [
        f"  {joints} over more than a turn, which these questions need: if cables do not allow it, narrow limits in dataset.yaml"
    ]


def _lines_on_signal(answers: Sequence[Answer]) -> list[str]:
    """Return what the numbers of the answers mean; and, where the measured poses should distinguish two effects already, why the question is open."""
    from scalar.planning.separation import ANSWERED

    lines = [
        "  the two numbers are the signal that answers the question, with the measured poses and with the planned ones as well: from "
        f"{ANSWERED**0.5:g} standard errors on it counts as answered"
    ]
    if any(answer.now >= ANSWERED for answer in answers):
        lines.append(
            "  where the measured poses reach this already, one of the diagnosis's rules keeps the name unsure: the report says which"
        )
    return lines


def _nothing_separable(
    pairs: Sequence[Pair], answers: Sequence[Answer], found: Candidates, dataset: Dataset, path: Path
) -> Undetermined:
    """Return the refusal if the candidates separate none of the pairs, each with its answer, that the diagnosis in the file ``path`` leaves open."""
    from scalar.planning.separation import ANSWERED

    near = any(_noise_to_separate(answer) <= _FAR or answer.alone < ANSWERED for answer in answers)
    remedy = f"{_LESS_NOISE}; {_otherwise(dataset)}" if near else _otherwise(dataset)
    return Undetermined(
        [
            *(_not_separable(*each, len(found.q)) for each in zip(pairs, answers, strict=True)),
            _NOTHING + remedy,
            _more_poses(path),
        ]
    )


def _nothing_to_plan(path: Path, is_open: bool) -> list[str]:
    """Return lines that say that no poses are planned, and how they are planned all the same.

    Args:
        path: The file of the diagnosis.
        is_open: Whether it leaves questions open, which no poses answer.
    """
    left = "of what it leaves open, further poses answer nothing" if is_open else "it leaves nothing open"
    return [
        f"{path}: {left}: none are planned, and nothing is written",
        f"  {_more_poses(path)}",
    ]


def _more_poses(path: Path) -> str:
    """Return how poses are planned that separate no effects, but make what was found surer."""
    return (
        f"for more poses of the arm as it was calibrated, which confirm what was found and hold enough equations where there were too few, "
        f"plan with --near {path.parent / 'after.json'} and without --after"
    )


def check_belongs(path: Path, dataset: Dataset, calibration: Calibration) -> None:
    """Refuse the diagnosis of another dataset, as far as its calibration shows that.

    Args:
        path: The file of the diagnosis.
        dataset: The dataset that is said to have been diagnosed.
        calibration: The calibration after the diagnosis.

    Raises:
        InvalidInput: The calibration is from another kind of sensor, from planes that the dataset does not have, or from more poses.
    """
    from scalar.geometry.planes import Planes

    theirs, ours = calibration.sensor["kind"], dataset.sensor.kind
    target, poses = calibration.model.target, calibration.summary.get("poses", 0)
    here = f"'{dataset.name}'"
    strange = (
        set(target.names) - {plane.name for plane in dataset.planes} if isinstance(target, Planes) else ()
    )
    if theirs != ours:
        what = f"its sensor is a {theirs}, and that of {here} is a {ours}"
    elif strange:
        what = f"it measured the plane '{min(strange)}', which {here} does not have"
    elif poses > dataset.n_poses:
        what = f"it was made from {poses} poses, and {here} has {dataset.n_poses}"
    else:
        return
    message = f"the diagnosis of another dataset: {what}; give the folder that was diagnosed"
    raise InvalidInput(Fault(str(path), message))


def read_questions(path: Path, found: Sequence[Effect], dataset: Dataset) -> tuple[list[Pair], list[str]]:
    """Return what ``open_pairs`` returns for the diagnosis in a file.

    Args:
        path: The file of the diagnosis.
        found: The effects of the calibration after the diagnosis.
        dataset: The dataset that was diagnosed.

    Raises:
        InvalidInput: The file is no diagnosis, or is damaged.
    """
    from scalar.planning.questions import open_pairs

    diagnosis = _read(path)
    try:
        return open_pairs(diagnosis, found, dataset)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        message = f"damaged diagnosis: {type(error).__name__} {error}; diagnose again"
        raise InvalidInput(Fault(str(path), message)) from None


def _noise_to_separate(answer: Answer) -> float:
    """Return how many times smaller noise and repeatability would have to be for all candidates together to answer a question."""
    from scalar.planning.separation import ANSWERED

    return (ANSWERED / max(answer.limit, 1e-12)) ** 0.5


def _not_separable(pair: Pair, answer: Answer, candidates: int) -> str:
    """Return that no candidates answer a question, with the signal that all of them give, and whether less noise would help."""
    from scalar.planning.separation import ANSWERED

    show = "show" if pair.rival is None else "separate"
    said = (
        f"{answer.question.title}: no poses {show} it; all {candidates} candidates together give a signal of {answer.limit**0.5:.1f} "
        "standard errors"
    )
    factor = _noise_to_separate(answer)
    if factor <= _FAR:
        return f"{said}, and {ANSWERED**0.5:g} are needed: noise and repeatability would have to be {factor:.1f} times smaller"
    if answer.alone < ANSWERED:
        return f"{said}, and {ANSWERED**0.5:g} are needed: at its size it moves the sensor by less than these measurements can show"
    remedy = f"; {pair.effect.remedy}" if pair.effect.remedy else ""
    return (
        f"{said}, and {ANSWERED**0.5:g} are needed: at all candidates, other causes move the measurements in the same way, so a better sensor would "
        f"not help{remedy}"
    )


def _otherwise(dataset: Dataset) -> str:
    """Return what may show an effect that no candidate shows, for this kind of sensor."""
    from scalar.sensors import kind_of

    ways = ["wider joint limits"]
    ways += ["--range and --fan"] if kind_of(dataset).scans else []
    ways += ["other target planes"] if dataset.planes else []
    recorded = (
        "a column that was not recorded (approach, temperature, torque) may show what these poses cannot"
    )
    return f"{', '.join(ways)}, or {recorded}"


def _read(path: Path) -> dict[str, Any]:
    """Return the content of a file that states to be a diagnosis."""
    from scalar.data.io.json_reader import read_json
    from scalar.data.io.run_id import check_run

    if not path.exists():
        raise InvalidInput(Fault(str(path), "no such file; `scalar diagnose DATASET -o DIR` writes one"))
    check_run(path)
    content: Any = read_json(path)
    if not isinstance(content, dict) or content.get("format") not in _FORMATS:
        raise InvalidInput(
            Fault(str(path), f"not a diagnosis: its format is not '{_FORMATS[-1]}'", None, "format")
        )
    return content
