"""Reduce a diagnosis to an answer of plain values, and list the statements in which two answers differ."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from scalar.diagnosis import Diagnosis
from scalar.errors import ScalarError
from scalar.evaluate import aligned_to, pose_errors, true_frames
from scalar.units import MM
from study.blind_trials.score import SURE

KINDS = {
    "refused": "whether the data are refused",
    "verdict": "the verdict",
    "names": "which effects are named",
    "targets": "the joint, order, target plane or moment of a named effect",
    "confidence": "whether a confidence is below 0.8 or not",
    "confounded": "what is listed as confounded with an effect",
    "unobservable": "what is listed as unobservable",
    "set_aside": "which poses and points are set aside",
    "fixed": "which parameters are fixed",
    "coefficients": "a coefficient, by more than a thousandth of its effect's size",
    "errors": "the error or the stated uncertainty at poses not measured, by more than a thousandth",
}
"""``{kind of statement: what it says}``, the kinds whose change is gravest first."""
NAMING = ("refused", "verdict", "names", "targets")
"""The kinds of statements on whether the data are refused, and on what is named."""
RELATIVE = 1e-3  # relative change of a number from which on it counts as another number

Answer = Mapping[str, Any]
"""As ``answer_of`` or ``refusal`` returns it."""


def answer_of(diagnosis: Diagnosis, truth_poses: pd.DataFrame) -> dict[str, Any]:
    """Return a diagnosis' statements as plain values.

    Args:
        diagnosis: The diagnosis of one set.
        truth_poses: Poses that are not in the set, with their true frames.
    """
    mapping = diagnosis.to_mapping()
    after = diagnosis.calibration_after
    T_true = true_frames(truth_poses)
    try:
        unseen = pose_errors(T_true, aligned_to(T_true, after.predict(truth_poses))).position.mean()
        stated = after.predict_std(truth_poses)[0].mean()
    except ScalarError:
        unseen = stated = np.nan
    return {
        "refused": "",
        "verdict": mapping["verdict"],
        "effects": [
            {
                "name": entry["name"],
                "target": json.dumps(entry["target"], sort_keys=True),
                "confidence": entry["confidence"],
                "confounded": sorted(_place(other) for other in entry["confounded_with"]),
                "coefficients": {key: c["value"] for key, c in entry["coefficients"].items()},
            }
            for entry in mapping["effects"]
        ],
        "unobservable": sorted(_place(entry) for entry in mapping["unobservable"]),
        "set_aside": [
            mapping["outliers"]["poses"],
            mapping["outliers"]["points"],
            mapping["outliers"]["mislabelled"],
        ],
        "fixed": sorted(after.fixed),
        "held_out_mm": mapping["residual"]["after"]["held_out_rms_mm"],
        "unseen_mm": float(unseen / MM),
        "stated_mm": float(stated / MM),
    }


def refusal(error: Exception) -> dict[str, Any]:
    """Return the answer of a diagnosis that ended with an error: the error's class and the first line of its message."""
    return {"refused": f"{type(error).__name__}: {error}".splitlines()[0]}


def _place(entry: Mapping[str, Any]) -> str:
    """Return name and target of an effect as text."""
    return f"{entry['name']} {json.dumps(entry['target'], sort_keys=True)}"


def differences(default: Answer, other: Answer) -> dict[str, str]:
    """Return ``{kind of statement: the change in words}`` of all kinds in which an answer differs from that with the default settings."""
    if default["refused"] or other["refused"]:
        # The text of a refusal may quote a number; its kind is what counts.
        kinds = [answer["refused"].split(":")[0] for answer in (default, other)]
        if kinds[0] == kinds[1]:
            return {}
        return {"refused": f"{default['refused'] or 'diagnosed'} became {other['refused'] or 'diagnosed'}"}
    found = {}
    for kind, texts in {
        "verdict": [answer["verdict"] for answer in (default, other)],
        "names": [_listed(_names(answer)) for answer in (default, other)],
        "targets": [_listed(_places(answer)) for answer in (default, other)],
    }.items():
        if texts[0] != texts[1]:
            found[kind] = f"{texts[0]} became {texts[1]}"
    if "names" in found:
        found.pop("targets", None)
    found |= _of_the_same_effects(default, other)
    for kind in ("unobservable", "set_aside", "fixed"):
        if default[kind] != other[kind]:
            found[kind] = f"{KINDS[kind]}: {_change(default[kind], other[kind])}"
    for key, what in (
        ("unseen_mm", "error at poses not measured"),
        ("stated_mm", "stated uncertainty there"),
    ):
        if relative_change(default[key], other[key]) > RELATIVE:
            found.setdefault("errors", f"{what} {default[key]:.4g} mm became {other[key]:.4g} mm")
    return {kind: found[kind] for kind in KINDS if kind in found}


def _of_the_same_effects(default: Answer, other: Answer) -> dict[str, str]:
    """Return the differences between effects that both answers name at the same place."""
    found: dict[str, str] = {}
    there = {(e["name"], e["target"]): e for e in other["effects"]}
    for entry in default["effects"]:
        match = there.get((entry["name"], entry["target"]))
        if match is None:
            continue
        name = entry["name"]
        if (entry["confidence"] >= SURE) != (match["confidence"] >= SURE):
            text = f"confidence of {name} {entry['confidence']:.2f} became {match['confidence']:.2f}"
            found.setdefault("confidence", text)
        if entry["confounded"] != match["confounded"]:
            text = f"confounded with {name}: {_change(entry['confounded'], match['confounded'])}"
            found.setdefault("confounded", text)
        change = _coefficients_change(entry["coefficients"], match["coefficients"])
        if change > RELATIVE:
            found.setdefault("coefficients", f"coefficients of {name} changed by {100 * change:.2g} %")
    return found


def _coefficients_change(a: Mapping[str, float], b: Mapping[str, float]) -> float:
    """Return the largest change of a coefficient, divided by the largest coefficient of the effect."""
    if set(a) != set(b):
        return np.inf
    size = max((abs(value) for value in a.values()), default=0.0)
    change = max((abs(b[key] - a[key]) for key in a), default=0.0)
    return change / size if size else (np.inf if change else 0.0)


def relative_change(before: float, after: float) -> float:
    """Return the relative change of a positive number; 0 if it is missing (NaN) before and after."""
    if np.isnan(before) and np.isnan(after):
        return 0.0
    if np.isnan(before) or np.isnan(after) or before == 0.0:
        return 0.0 if before == after else np.inf
    return abs(after / before - 1.0)


def _names(answer: Answer) -> list[str]:
    """Return the names of the effects that an answer contains."""
    return sorted(entry["name"] for entry in answer["effects"])


def _places(answer: Answer) -> list[str]:
    """Return the names of the effects with their targets."""
    return sorted(
        entry["name"] if entry["target"] == "{}" else f"{entry['name']} {entry['target']}"
        for entry in answer["effects"]
    )


def _listed(items: list[str]) -> str:
    return ", ".join(items) or "nothing"


def _change(before: list[Any], after: list[Any]) -> str:
    """Return in words how the number of listed things changed."""
    is_set_aside = len(before) == len(after) and before and isinstance(before[0], list)
    if is_set_aside:  # two lists of poses and a number of points, not a list of things
        return f"{_count(before)} became {_count(after)}"
    return f"{len(before)} became {len(after)}"


def _count(set_aside: list[Any]) -> str:
    poses, points, mislabelled = set_aside
    return f"{len(poses)} poses and {points} points ({len(mislabelled)} mislabelled)"
