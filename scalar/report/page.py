"""What the report says, section by section: a diagnosis in, texts, tables and pictures out, for the
template to lay out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.diagnosis.partial_residuals import FittedView
from scalar.diagnosis.separating_poses import separation
from scalar.diagnosis.variance_components import whitening_for
from scalar.effects.picture import Map, Profile
from scalar.report import shipped_words, unseen_words, words
from scalar.report.advice import advice
from scalar.report.own_noise import own_noise
from scalar.report.pictures import draw
from scalar.report.residual_pictures import draw_residuals, draw_scatter
from scalar.report.thinning import dots_per_panel
from scalar.sensors import kind_of
from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis, Finding

VERDICTS = {
    "no_effect": "Nothing but noise",
    "effect": "Found what the model lacks",
    "unattributed": "Structure that no known effect explains",
}
_NAMED_IN_SENTENCE = 4
_RANKS_SHOWN = 8
_MANY_PICTURES = 12  # effects with pictures; what comes after has its table only
_RIVALS_SHOWN = 3


def page(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return everything that the template needs."""
    mapping = diagnosis.to_mapping()
    view = FittedView.of(
        diagnosis.after, diagnosis.calibration_found.free, diagnosis.calibration_found.covariance
    )
    shown = [effect.pictures(view) for effect in diagnosis.after.effects[:_MANY_PICTURES]]
    most = dots_per_panel(2 * (sum(len(pictures) for pictures in shown) + 1))
    effects = [
        _card(diagnosis, view, i, finding, shown[i] if i < len(shown) else [], most)
        for i, finding in enumerate(diagnosis.findings)
    ]
    if diagnosis.confirmed_noise and not diagnosis.flexible_terms:
        effects.append(_noise_card(diagnosis))
    return {
        "name": diagnosis.dataset.name,
        "about": _about(diagnosis),
        "verdict": mapping["verdict"],
        "headline": VERDICTS[mapping["verdict"]],
        "sentence": _sentence(mapping, effects),
        "unseen": unseen_words.unseen_sentences(diagnosis, mapping),
        "shipped": shipped_words.shipped_sentences(diagnosis),
        "errors": _errors(mapping, bool(diagnosis.findings)),
        "effects": effects,
        "residuals": draw_residuals(diagnosis.before, diagnosis.after, most),
        "ranking": _ranking(diagnosis),
        "unobservable": _unobservable(diagnosis),
        "on_planes": bool(diagnosis.dataset.planes),
        "set_aside": mapping["outliers"],
        "noise": _noise(diagnosis, mapping),
        "advice": advice(diagnosis, mapping),
        "gauge": [dict(entry) for entry in diagnosis.calibration_after.gauge],
    }


def _about(diagnosis: Diagnosis) -> str:
    dataset = diagnosis.dataset
    parts = [
        f"robot {dataset.robot.name}, {dataset.robot.n_joints} joints",
        kind_of(dataset).words,
    ]
    parts.append(f"{dataset.n_poses} poses")
    if len(dataset.planes):
        parts.append(f"{len(np.unique(dataset.plane_index))} target planes")
    if kind_of(dataset).scans:
        parts.append(f"{len(dataset.points):,} points".replace(",", "\u202f"))
    return " · ".join(parts)


def _sentence(mapping: Mapping[str, Any], effects: list[dict[str, Any]]) -> str:
    before, after = (mapping["residual"][when]["held_out_rms_mm"] for when in ("before", "after"))
    floor = mapping["residual"]["floor_mm"]
    level = f"noise alone would leave {words.number(floor)} mm"
    if not effects:
        return (
            "These data show nothing that the model lacks: on poses held out from the fit the error is "
            f"{words.number(before)} mm, and {level}."
        )
    texts = [e["clause"] + (f" ({e['size']})" if e["size"] else "") for e in effects]
    more = len(texts) - _NAMED_IN_SENTENCE
    if more > 1:
        texts = [*texts[:_NAMED_IN_SENTENCE], f"{more} more effects"]
    opening = words.capital(words.listed(texts))
    if all(e["is_noise"] for e in effects):
        held = f"On poses held out from the fit the error is {words.number(after)} mm; {level}."
        return f"{opening}. {words.capital(effects[0]['text'])}. {held}"
    change = "falls" if after < before else "changes"
    return (
        f"{opening}. With {'this' if len(effects) == 1 else 'these'} in the model, the error on poses "
        f"held out from the fit {change} from {words.number(before)} to {words.number(after)} mm; {level}."
    )


def _errors(mapping: Mapping[str, Any], changed: bool) -> dict[str, Any]:
    """Return the bars of the errors: all are lengths, and all have one scale; one bar a row where nothing
    was added to the model."""
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
                        "label": when if changed else "",
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
    effect = finding.effect
    poses = diagnosis.after.dataset.poses["pose"].to_numpy()
    return {
        "title": effect.title,
        "clause": effect.clause,
        "text": effect.sentence,
        "is_noise": False,
        "flexible": effect.flexible,
        "size": effect.size(pictures),
        "p_value": words.chance(finding.p_value),
        "sure": f"{100 * finding.confidence:.0f} %",
        "chosen": unseen_words.share({"selected_in": finding.selected_in}, diagnosis),
        "before": words.number(finding.before.rms / MM),
        "after": words.number(finding.after.rms / MM),
        "seen": f"{100 * view.share_left(diagnosis.after.effects[index]):.0f} %",
        "table": _coefficients(finding),
        "pictures": [draw(picture, poses, most) for picture in pictures],
        "confounded": _confounded(diagnosis, index, finding),
    }


def _coefficients(finding: Finding) -> dict[str, Any] | None:
    table = finding.effect.table(finding.std)
    return None if table is None else {"head": table[0], "rows": table[1]}


def _confounded(diagnosis: Diagnosis, index: int, finding: Finding) -> dict[str, Any] | None:
    if not finding.confounded_with:
        return None
    near = list(finding.confounded_with)
    titles = [e.title for e in near]
    found = separation(diagnosis.after, index, near[0])
    text = ""
    if found is not None:
        text = (
            f"Poses with joint {found.joint} between {words.angle(found.low)} and "
            f"{words.angle(found.high)} would distinguish it best from "
            f"{titles[0]}: there the two explanations put the sensor {words.length(found.there)} "
            "apart, and "
            f"{words.length(found.here)} at the poses that were measured."
        )
    more = len(titles) - _RIVALS_SHOWN
    shown = titles[:_RIVALS_SHOWN] + ([f"{more} more"] if more > 0 else [])
    return {"names": words.listed(shown, "or"), "poses": text}


def _of_spread(diagnosis: Diagnosis) -> str:
    """Return why the variance between poses is no noise; empty where it is."""
    if diagnosis.exceeds_any_repeatability:
        return "the poses scatter by more than the repeatability of any arm, and no effect was found that explains it: something acts on them"
    if diagnosis.depends_on:
        along = words.listed([words.column(name) for name in diagnosis.depends_on])
        return f"the errors of poses follow {along}, as noise does not: something acts on the poses"
    return ""


def _noise_card(diagnosis: Diagnosis) -> dict[str, Any]:
    best = diagnosis.noise[0]
    entry = diagnosis.noise_entry()
    is_angle = best.name == "pose_jitter"
    state = diagnosis.after
    residual = state.linearised()[0][: len(best.covariance) * best.covariance.shape[1]]
    rows = residual.reshape(len(best.covariance), -1)
    mixed = np.einsum("nij,nj->ni", whitening_for(best), rows)
    pick = state.residuals.measurement.shift_rows
    near = [words.title(c["name"], c["target"]) for c in entry["confounded_with"]]
    how = (
        "the joints scatter from pose to pose"
        if is_angle
        else "each scan has an error of its own, common to its points"
    )
    title = words.title(entry["name"], {})
    is_component = entry["name"] in words.COMPONENTS
    return {
        "title": title,
        "clause": words.COMPONENTS[entry["name"]][1] if is_component else f"there is {title}",
        "text": _of_spread(diagnosis) or f"{how}: a random error, which no correction removes",
        "is_noise": True,
        "flexible": False,
        "size": f"{words.angle(best.std) if is_angle else words.length(best.std)} standard deviation",
        "p_value": words.chance(best.p_value),
        "sure": f"{100 * entry['confidence']:.0f} %",
        "chosen": unseen_words.share(entry, diagnosis),
        "before": None,
        "after": None,
        "seen": None,
        "table": {
            "head": ("coefficient", "value", "±", "unit"),
            "rows": [
                (
                    "standard deviation",
                    words.number(best.std / (DEG if is_angle else MM)),
                    words.number(best.std_error / (DEG if is_angle else MM), 2),
                    "° in each joint" if is_angle else "mm",
                )
            ],
        },
        "pictures": [
            draw_scatter(rows[:, pick].ravel(), mixed[:, pick].ravel(), not diagnosis.component_is_no_noise)
        ],
        "confounded": {"names": words.listed(near, "or"), "poses": ""} if near else None,
    }


def _ranking(diagnosis: Diagnosis) -> dict[str, Any]:
    squared = max(diagnosis.before.background().squared, 1e-300)
    taken = {f.effect.title for f in diagnosis.findings}
    top = max([entry.evidence for entry in diagnosis.ranking] + [1e-9])
    # A candidate with several sets of columns has one line, for its best.
    best = {entry.effect.title: entry for entry in reversed(diagnosis.ranking)}
    rows = [
        {
            "title": words.capital(entry.effect.title),
            "evidence": f"{round(entry.evidence)}".replace("-", "−"),
            "percent": _percent(max(entry.evidence, 0.0), top),
            "p_value": words.chance(entry.p_value),
            "share": f"{100 * min(entry.gain / squared, 1.0):.1f} %",
            "taken": entry.effect.title in taken,
        }
        for entry in diagnosis.ranking
        if best[entry.effect.title] is entry
    ]
    return {"first": rows[:_RANKS_SHOWN], "rest": rows[_RANKS_SHOWN:]}


def _unobservable(diagnosis: Diagnosis) -> list[dict[str, str]]:
    """Return what cannot be seen, effects of the same consequence together."""
    together: dict[str, list[str]] = {}
    for entry in diagnosis.unobservable:
        together.setdefault(entry.consequence, []).append(entry.effect.title)
    return [
        {"title": words.capital("; ".join(dict.fromkeys(titles))), "text": text}
        for text, titles in together.items()
    ]


def _noise(diagnosis: Diagnosis, mapping: Mapping[str, Any]) -> dict[str, Any]:
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
