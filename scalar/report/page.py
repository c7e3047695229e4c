"""Turn a diagnosis into the texts, tables and pictures of the report's sections, which the template lays out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.diagnosis.fit.partial_residuals import FittedView
from scalar.diagnosis.shipping.shipped_fit import BY_COMPONENT
from scalar.effects.command_line import named_effects
from scalar.effects.picture import Map, Profile
from scalar.report import further_poses, shipped_words, unmeasured_words, unseen_words, words
from scalar.report.advice import advice
from scalar.report.diagnosed_workspace import diagnosed_workspace
from scalar.report.excess_words import unexplained_excess
from scalar.report.noise_card import noise_card
from scalar.report.opening import opening, verdict_on_effects, verdict_on_structure
from scalar.report.own_noise import own_noise
from scalar.report.parameter_table import convention_in_words, gauge_rows, parameter_tables
from scalar.report.pictures import draw
from scalar.report.residual_pictures import draw_residuals
from scalar.report.thinning import dots_per_panel
from scalar.report.unseen_directions_words import unseen_directions_sentences
from scalar.sensors import kind_of
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.diagnosis.naming.finding import Finding
    from scalar.diagnosis.result import Diagnosis
    from scalar.effects import Effect

NO_EFFECT = "No effect found"
DOUBTFUL = (
    "the model lacks something here, and this known effect has the shape nearest to it; but a name with such evidence is hardly more often right "
    "than wrong, so take it as a hint"
)
NOISE_ONLY = "Only random errors found"
_RANKS_SHOWN = 8  # candidates of the ranking, and unobservable effects, that are not folded away
_MANY_PICTURES = 12  # effects with pictures; those after them have a table only
_RIVALS_SHOWN = 3  # confounded effects that are named


def page(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return everything that the template ``report.html.jinja`` needs, by the names of its variables."""
    mapping = diagnosis.to_mapping()
    view = FittedView.of(
        diagnosis.after, diagnosis.calibration_found.free, diagnosis.calibration_found.covariance
    )
    shown = [
        effect.pictures(view)
        for effect in diagnosis.after.effects[: min(len(diagnosis.findings), _MANY_PICTURES)]
    ]
    most = dots_per_panel(2 * (sum(len(pictures) for pictures in shown) + 1))
    effects = [
        _card(diagnosis, view, i, finding, shown[i] if i < len(shown) else [], most)
        for i, finding in enumerate(diagnosis.findings)
    ]
    if diagnosis.reported_noise:
        effects.append(noise_card(diagnosis))
    return {
        "name": diagnosis.dataset.name,
        "about": _about(diagnosis),
        "verdict": mapping["verdict"],
        "headline": _headline(diagnosis),
        "opening": opening(diagnosis, mapping, shown),
        "setup": [entry["sentence"] for entry in diagnosis.setup],
        "files": _files(diagnosis),
        "unseen": [
            *unseen_words.unseen_sentences(diagnosis, mapping),
            unmeasured_words.unmeasured_sentence(mapping),
            *unseen_directions_sentences(diagnosis.calibration_after),
        ],
        "shipped": [*unexplained_excess(diagnosis), *shipped_words.shipped_sentences(diagnosis)],
        "errors": _errors(mapping, bool(diagnosis.findings)),
        "workspace": diagnosed_workspace(diagnosis),
        "file": "after.json",
        "convention": convention_in_words(diagnosis.dataset.robot),
        "parameters": parameter_tables(diagnosis.calibration_after, diagnosis.dataset.sensor.T_flange_sensor),
        "effects": effects,
        "confidence": words.CONFIDENCE,
        "residuals": draw_residuals(diagnosis.before, diagnosis.after, most),
        "ranking": _ranking(diagnosis),
        "unobservable": _unobservable(diagnosis),
        "on_planes": bool(diagnosis.dataset.planes),
        "set_aside": mapping["outliers"],
        "noise": _noise(diagnosis, mapping),
        "advice": advice(diagnosis, mapping),
        "gauge": gauge_rows(diagnosis.calibration_after),
        "planes": bool(diagnosis.dataset.planes),
    }


def _about(diagnosis: Diagnosis) -> str:
    """Return the line below the heading: robot, sensor, and what was measured."""
    dataset = diagnosis.dataset
    parts = [
        f"robot {dataset.robot.name}, {dataset.robot.n_joints} joints",
        kind_of(dataset).words,
    ]
    parts.append(f"{dataset.n_poses} poses")
    if len(dataset.planes):
        parts.append(f"{len(np.unique(dataset.plane_index))} target planes")
    if len(dataset.targets) > 1:
        parts.append(f"{len(dataset.targets)} targets on the flange")
    if kind_of(dataset).scans:
        parts.append(f"{len(dataset.points):,} points".replace(",", "\u202f"))
    return " · ".join(parts)


def _headline(diagnosis: Diagnosis) -> str:
    """Return the verdict in words."""
    only_noise = diagnosis.verdict == "effect" and not diagnosis.findings
    if only_noise:
        return NOISE_ONLY
    if diagnosis.verdict == "no_effect":
        return NO_EFFECT
    return words.capital(
        (verdict_on_effects if diagnosis.verdict == "effect" else verdict_on_structure)(diagnosis)
    )


def _files(diagnosis: Diagnosis) -> list[str]:
    """Return sentences on what ``before.json`` and ``after.json`` contain, and on how to use ``after.json``."""
    use = (
        "'scalar correct after.json program.csv -o corrected.csv' writes joint angles at which the arm stands where it is wanted, "
        "'scalar predict after.json joints.csv -o frames.csv' says where it stands, and 'scalar export' writes its geometry for controllers."
    )
    if diagnosis.shipped.without_effects:
        return [f"after.json is the same calibration as before.json. {use}"]
    if not diagnosis.findings:
        other = (
            "the one with equal weights for all poses"
            if diagnosis.shipped.fit == BY_COMPONENT
            else "the same"
        )
        return [f"after.json is the calibration of arm, sensor and target; before.json is {other}. {use}"]
    what = "this effect" if len(diagnosis.findings) == 1 else "these effects"
    if not diagnosis.shipped.choice.as_found:
        what = "what was found, as far as these data determine it,"
    return [
        f"after.json is the calibration that takes {what} into account; before.json is the one of the geometry alone. {use}"
    ]


def _errors(mapping: Mapping[str, Any], changed: bool) -> dict[str, Any]:
    """Return the bars of the held-out errors, all on one scale: before and after, or after alone if nothing was added to the model."""
    residual = mapping["residual"]
    floor = residual["floor_mm"]
    errors = {
        label: [(when, residual[when][key]) for when in (("before", "after") if changed else ("after",))]
        for label, key in (("root mean square", "held_out_rms_mm"), ("worst pose", "held_out_max_mm"))
    }
    scale = 1.04 * max([floor, *(value for bars in errors.values() for _, value in bars)])
    return {
        "floor": {"text": words.number(floor), "percent": _percent(floor, scale)},
        "rows": [
            {
                "label": label,
                "bars": [
                    {
                        "when": when,
                        "label": f"{when}.json" if changed else "",
                        "text": words.number(value),
                        "percent": _percent(value, scale),
                    }
                    for when, value in bars
                ],
            }
            for label, bars in errors.items()
        ],
    }


def _percent(value: float, scale: float) -> float:
    return round(100.0 * value / scale, 1) if scale > 0 else 0.0


def _card(
    diagnosis: Diagnosis,
    view: FittedView,
    index: int,
    finding: Finding,
    pictures: list[Profile | Map],
    most: int,
) -> dict[str, Any]:
    """Return the section of one finding: its texts, its table and its pictures, with at most ``most`` dots in each panel."""
    effect = finding.effect
    poses = diagnosis.after.dataset.poses["pose"].to_numpy()
    return {
        "title": f"structure that resembles {words.quoted(effect.title)}"
        if finding.doubtful
        else effect.title,
        "text": DOUBTFUL if finding.doubtful else effect.sentence,
        "is_noise": False,
        "described_as": effect.described_as,
        "option": named_effects([effect]),
        "size": effect.size(pictures),
        "p_value": words.chance(finding.p_value),
        "sure": words.confident(finding.confidence),
        "limit": finding.limit,
        "chosen": unseen_words.share({"selected_in": finding.selected_in}, diagnosis),
        "before": words.number(finding.before.rms / MM),
        "after": words.number(finding.after.rms / MM),
        "seen": f"{100 * view.share_left(diagnosis.after.effects[index]):.0f} %",
        "table": _coefficients(finding),
        "pictures": [draw(picture, poses, most) for picture in pictures],
        "confounded": _confounded(diagnosis, finding),
    }


def _coefficients(finding: Finding) -> dict[str, Any] | None:
    table = finding.effect.table(finding.std)
    return None if table is None else {"head": table[0], "rows": table[1]}


def _confounded(diagnosis: Diagnosis, finding: Finding) -> dict[str, Any] | None:
    """Return the effects with which a finding is confounded, and whether further poses distinguish it from the first; None if there are none."""
    if not finding.confounded_with:
        return None
    near = list(finding.confounded_with)
    titles = [e.title for e in near]
    more = len(titles) - _RIVALS_SHOWN
    shown = [words.quoted(title) for title in titles[:_RIVALS_SHOWN]] + ([f"{more} more"] if more > 0 else [])
    return {"names": words.listed(shown, "or"), "poses": further_poses.in_words(diagnosis, finding)}


def _ranking(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the table of the candidates by their evidence: the first ones and those that were added, and the others apart."""
    sum_of_squares = max(diagnosis.before.background().sum_of_squares, 1e-300)
    found = [f.effect for f in diagnosis.findings]
    # A candidate with several sets of columns has one line, for its best. One of which the poses show nothing has no evidence and no line.
    ranked = [entry for entry in diagnosis.ranking if entry.dof]
    top = max([entry.evidence for entry in ranked] + [1e-9])
    best = {entry.effect.title: entry for entry in reversed(ranked)}
    rows = [
        {
            "title": words.capital(entry.effect.title),
            "evidence": f"{round(entry.evidence)}".replace("-", "−"),
            "percent": _percent(max(entry.evidence, 0.0), top),
            "p_value": words.chance(entry.p_value),
            "share": f"{100 * min(entry.gain / sum_of_squares, 1.0):.1f} %",
            "taken": any(_is_of(entry.effect, effect) for effect in found),
        }
        for entry in ranked
        if best[entry.effect.title] is entry
    ]
    first = [row for i, row in enumerate(rows) if i < _RANKS_SHOWN or row["taken"]]
    given_others = [
        words.quoted(effect.title)
        for effect in found
        if not effect.flexible and not any(_is_of(entry.effect, effect) for entry in ranked)
    ]
    return {
        "first": first,
        "rest": [row for row in rows if row not in first],
        "later": words.listed(given_others),
        "one_later": len(given_others) == 1,
    }


def _is_of(candidate: Effect, found: Effect) -> bool:
    """Return whether a candidate is an effect that was found, or a part of it: one of the joints that give way, say."""
    if candidate.title == found.title:
        return True
    both = found.merged_with(candidate)
    return both is not None and set(both.term_names) == set(found.term_names)


def _unobservable(diagnosis: Diagnosis) -> dict[str, list[dict[str, str]]]:
    """Return the unobservable effects, the most harmful first, those of the same consequence in one row; rows after the first few are apart."""
    together: dict[str, list[str]] = {}
    for entry in sorted(diagnosis.unobservable_alone, key=lambda entry: -entry.prediction_error):
        together.setdefault(entry.consequence, []).append(entry.effect.title)
    rows = [
        {"title": words.capital("; ".join(dict.fromkeys(titles))), "text": text}
        for text, titles in together.items()
    ]
    return {"first": rows[:_RANKS_SHOWN], "rest": rows[_RANKS_SHOWN:]}


def _noise(diagnosis: Diagnosis, mapping: Mapping[str, Any]) -> dict[str, Any]:
    """Return the noise within and between scans, where its size comes from, and what is known of its causes."""
    noise = mapping["noise"]
    stated = diagnosis.dataset.sensor.noise
    between = noise["between_scans_mm"]
    off = stated is not None and not np.isclose(stated / MM, noise["within_scan_mm"])
    return {
        "within": words.number(noise["within_scan_mm"]),
        "between": f"{words.number(between, 2)} mm" if between > 0 else "",
        "source": "as the dataset states it" if stated is not None and not off else "as these data show it",
        "scans": kind_of(diagnosis.dataset).scans,
        "own": own_noise(diagnosis),
    }
