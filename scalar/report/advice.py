"""What to do next: repairs of what was found, and measurements for what these data could not show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.poses import is_joint
from scalar.diagnosis.naming.finding import UNATTRIBUTED
from scalar.effects import registry
from scalar.effects.title import joints_in_words, joints_of
from scalar.effects.wording import KNOWN_LENGTH_ADVICE
from scalar.geometry.standard_dh import as_stated
from scalar.report.controller_geometry import better_in_controller
from scalar.report.few_poses import few_poses
from scalar.report.load_advice import load_advice
from scalar.report.noise_card import noise_advice
from scalar.report.opening import by_importance, caution
from scalar.report.words import angle, capital, length, listed, quoted
from scalar.robots import axis_in_brackets, axis_names_of
from scalar.sensors import kind_of
from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.diagnosis.naming.finding import Finding
    from scalar.diagnosis.result import Diagnosis
    from scalar.effects import Effect

WEAK_LENGTH = 0.2 * MM  # standard error from which more poses are advised
WEAK_ANGLE = 0.02 * DEG
HARDLY_MOVED = 0.5 * DEG  # range of a joint below which it counts as standing still
FEW_POSES_A_PLANE = 30  # with fewer poses on a plane, more are advised
_WEAK_SHOWN = 4  # least certain parameters that are listed by name
_FURTHER_TITLES = 6  # further findings of a kind that are listed by title after the most important one
GEOMETRY = (
    "The lengths and angles that were found replace those of the data sheet, if the controller lets them be entered: 'scalar export after.json "
    "-o parameters.csv' writes them. If it does not, 'scalar correct after.json program.csv -o corrected.csv' writes corrected joint angles of a "
    "program"
)
"""How the controller gets the calibrated geometry; a full stop, or a clause on effects, follows."""


GEOMETRY_AND_EFFECTS = (
    "'scalar correct after.json program.csv -o corrected.csv' writes corrected joint angles of a program, effects included; the controller keeps "
    "the lengths and angles that it has. A controller that takes lengths and angles cannot hold the effects: give it those of {better}: {errs} "
    "('scalar export {better} -o parameters.csv')."
)
"""How the controller gets the calibrated geometry where effects were found as well."""


UNKNOWN_CAUSE = (
    "Enter none of the lengths and angles that were found until the cause of the unmodelled structure is known, because they may carry a part of "
    "it. 'scalar correct after.json program.csv -o corrected.csv' corrects programs near the measured poses."
)


@dataclass(frozen=True)
class Item:
    """One thing to do.

    Attributes:
        about: What it is about, a heading; may be empty.
        sentences: What to do, the first thing first.
    """

    about: str
    sentences: tuple[str, ...]


def advice(diagnosis: Diagnosis, mapping: Mapping[str, Any]) -> list[Item]:
    """Return the advice, the most useful first.

    It says what to do about each kind of finding, what to change in the controller, and what to measure next.

    Args:
        diagnosis: The diagnosis to report.
        mapping: Its ``to_mapping()``.
    """
    more = [
        *few_poses(diagnosis),
        *_mislabelled(mapping),
        *_unobservable(diagnosis),
        *_weak(diagnosis),
        *load_advice(diagnosis),
        *_columns(diagnosis),
        *_poses(diagnosis),
    ]
    return [
        *_about_findings(diagnosis),
        *_in_controller(diagnosis),
        *(Item("", (sentence,)) for sentence in dict.fromkeys(more)),
    ]


def _about_findings(diagnosis: Diagnosis) -> list[Item]:
    """Return one item of advice for each kind of finding; it describes the most important finding of the kind and lists the others by title."""
    together: dict[tuple[str, bool], list[Finding]] = {}
    for finding in by_importance(diagnosis.findings):
        kind = finding.effect.reported_with or finding.effect.name
        together.setdefault((kind, finding.doubtful), []).append(finding)
    names = axis_names_of(diagnosis.dataset.robot)
    found: list[Item] = []
    for first, *others in together.values():
        effect, warning = first.effect, caution(diagnosis, first)
        if first.doubtful:
            how = [finding.effect.how_to_measure for finding in (first, *others)]
            found.append(
                Item("Structure without a certain name", tuple(dict.fromkeys(filter(None, [warning, *how]))))
            )
            continue
        texts = [*effect.advice, effect.how_to_measure]
        if effect.flexible:
            texts += [text for finding in others for text in finding.effect.advice]
        elif others and effect.advice:
            titles = list(dict.fromkeys(finding.effect.title for finding in others))
            more = [f"{len(titles) - _FURTHER_TITLES} more"] if len(titles) > _FURTHER_TITLES else []
            texts.append(f"Do the same for {listed([*map(quoted, titles[:_FURTHER_TITLES]), *more])}.")
        if warning and texts:
            texts = [
                warning.replace(quoted(effect.title), "it", 1),
                f"If it is confirmed: {texts[0][:1].lower()}{texts[0][1:]}",
                *texts[1:],
            ]
        found.append(
            Item(
                capital(effect.title) + axis_in_brackets(names, _joints_of(effect)),
                tuple(dict.fromkeys(filter(None, texts))),
            )
        )
    if diagnosis.reported_noise:
        found.append(Item("Random errors", tuple(noise_advice(diagnosis))))
    return [item for item in found if item.sentences]


def _joints_of(effect: Effect) -> list[int]:
    """Return the numbers of the joints at which an effect acts, or with which it varies, from 1; none for an effect of something else."""
    return joints_of(effect.target) or [int(name[1:]) for name in effect.depends_on if is_joint(name)]


def _in_controller(diagnosis: Diagnosis) -> list[Item]:
    """Return what to change in the controller: the geometry, and what each effect asks for; each sentence comes once."""
    asked = [finding.effect.in_controller for finding in by_importance(diagnosis.findings)]
    if diagnosis.verdict == UNATTRIBUTED:
        return [Item("In the controller", (UNKNOWN_CAUSE, *dict.fromkeys(filter(None, asked))))]
    geometry = f"{GEOMETRY}."
    if any(effect.acts_on_arm for effect in diagnosis.calibration_after.model.effects):
        better = better_in_controller(diagnosis)
        geometry = GEOMETRY_AND_EFFECTS.format(better=better[0], errs=better[1]) if better else f"{GEOMETRY}."
    return [Item("In the controller", (geometry, *dict.fromkeys(filter(None, asked))))]


def _unobservable(diagnosis: Diagnosis) -> list[str]:
    """Return what to measure so that unobservable effects become observable."""
    hidden = [entry.effect.remedy_advice for entry in diagnosis.unobservable]
    if not diagnosis.dataset.planes:
        hidden = [sentence for sentence in hidden if sentence != KNOWN_LENGTH_ADVICE]
    elif not kind_of(diagnosis.dataset).carries_scale:
        hidden = [KNOWN_LENGTH_ADVICE, *hidden]
    return [sentence for sentence in hidden if sentence]


def _weak(diagnosis: Diagnosis) -> list[str]:
    """Return the advice for geometric parameters with a large standard error."""
    parameters = diagnosis.calibration_after.parameters()
    nominal = diagnosis.calibration_after.model.nominal
    weak: list[tuple[float, int, str]] = []
    for name, entry in parameters.items():
        kind = name.split("_")[0]
        std = entry["std"]
        if kind not in ("a", "d", "alpha", "theta") or std is None:
            continue
        limit, say = (WEAK_LENGTH, length) if kind in ("a", "d") else (WEAK_ANGLE, angle)
        if std > limit:
            weak.append(
                (std / limit, int(name.rsplit("_", 1)[1]), f"{as_stated(name, nominal)} ± {say(std)}")
            )
    if not weak:
        return []
    shown = sorted(weak, reverse=True)[:_WEAK_SHOWN]
    named = [text for _, _, text in shown]
    more = f", and {len(weak) - len(named)} more" if len(weak) > len(named) else ""
    numbers = sorted({joint for _, joint, _ in shown})
    joints = joints_in_words(numbers) + axis_in_brackets(axis_names_of(nominal), numbers)
    return [
        f"Measure more poses in which {joints} and the neighbouring joints move "
        f"through all of their range: the least certain parameters are {listed(named)}{more}."
    ]


def _columns(diagnosis: Diagnosis) -> list[str]:
    """Return advice on columns that poses.csv could have, and on the noise that dataset.yaml should state."""
    kinds = registry.known().values()
    found = [sentence for kind in kinds for sentence in kind.advice_on_data(diagnosis.dataset)]
    if diagnosis.dataset.sensor.noise is None:
        found.append(
            "State the scanner's noise in dataset.yaml: it is then compared with the noise that the scans themselves show."
            if kind_of(diagnosis.dataset).scans
            else "State the sensor's noise in dataset.yaml (sensor.noise, in metres): then it is tested whether the residual is more than noise."
        )
    return found


def _poses(diagnosis: Diagnosis) -> list[str]:
    """Return advice on joints that hardly moved, and on planes with few poses."""
    dataset, found = diagnosis.dataset, []
    spans = np.ptp(dataset.q, axis=0)
    still = [int(j) + 1 for j in np.flatnonzero(spans < HARDLY_MOVED)]
    if still:
        axes = axis_in_brackets(axis_names_of(dataset.robot), still)
        found.append(
            f"Move {joints_in_words(still)}{axes}: these data say nothing about a joint that stands still."
        )
    if dataset.planes:
        counts = np.bincount(dataset.plane_index, minlength=len(dataset.planes))
        few = [
            f"{p.name} ({n})" for p, n in zip(dataset.planes, counts, strict=True) if n < FEW_POSES_A_PLANE
        ]
        if few:
            found.append(
                f"Measure more poses on {listed(few)}: effects show only with {FEW_POSES_A_PLANE} poses or more on each plane."
            )
    return found


def _mislabelled(mapping: Mapping[str, Any]) -> list[str]:
    wrong = mapping["outliers"]["mislabelled"]
    if not wrong:
        return []
    which = "the pose" if len(wrong) == 1 else "the poses"
    return [f"Correct the plane in poses.csv for {which} listed above, and run again."]
