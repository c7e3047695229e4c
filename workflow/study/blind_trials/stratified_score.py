"""Score the diagnosis of a set of the stratified trials: the rates to which it counts, of which several may apply to one set.

An entry of a diagnosis is *acceptable* if it is an injected effect with its target, or a fair description of something else that is truly there: a
bowed target plane, a distorting lens, or a cause that is no effect of the catalogue, but resembles one (``FAIR``). It is *listed* if its entry
``confounded_with`` contains an injected effect. Every other entry with a name is a *wrong name*. The components of the scanner's own noise are in
``noise.components`` of diagnosis.json, are no effects, and are not judged here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from study.blind_trials.score import NOISES, SURE, UNATTRIBUTED, Entry, same, same_target

WORSE, MUCH_WORSE = 1.05, 1.2
"""Ratios of the mean error over unseen poses after the diagnosis to that before it, above which a correction counts as worse, and as much worse."""
FAIR: Mapping[str, tuple[str, ...]] = {
    "air_conditioning": ("thermal_drift",),  # the links do become longer and shorter
    "sawtooth_growth": ("thermal_drift",),
    "encoder_interpolation": (
        "joint_ripple",
        "pose_jitter",
    ),  # 512 waves per turn look random at random angles
    "giving_floor": ("base_compliance",),  # the base does tilt under the moment, beyond a threshold
    "late_trigger": ("pose_lag",),
    "two_slope_gear": ("joint_compliance", "torque_compliance"),
    "vibration": ("pose_lag", "pose_jitter"),
}
"""``{unknown cause: effects that describe it fairly, if they state its joint or none}``."""


def acceptable(entry: Entry, truth: Mapping[str, Any]) -> bool:
    """Return whether an entry of a diagnosis describes something that is truly there.

    Args:
        entry: An entry of diagnosis.json.
        truth: ``injected`` (entries of truth.json), ``scanner`` and ``surface`` (blocks of truth.json, or None).
    """
    if any(same(entry, injected) for injected in truth["injected"]):
        return True
    if entry["name"] in flaws(truth):
        return True
    if entry["name"] == UNATTRIBUTED:
        return bool(flaws(truth))
    for injected in truth["injected"]:
        if entry["name"] in FAIR.get(injected.get("kind", ""), ()):
            named = _joints(entry)
            joint = injected["target"].get("joint")
            if joint is None or not named or joint in named:
                return True
    return False


def flaws(truth: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of the effects that describe the systematic errors of scanner and surface fairly; none if they have only noise."""
    surface, scanner = truth.get("surface") or {}, truth.get("scanner") or {}
    names: tuple[str, ...] = ("plane_bow",) if surface.get("bow_m") else ()
    return names + (("sensor_map", "range_distortion") if scanner.get("linearity_m") else ())


def _joints(entry: Entry) -> set[int]:
    """Return the joints that an entry's target states, counted from 1."""
    target = entry.get("target") or {}
    return set(target.get("joints") or ([target["joint"]] if "joint" in target else []))


def listed(entry: Entry, truth: Mapping[str, Any]) -> bool:
    """Return whether an injected effect is among those with which an entry is stated to be confounded."""
    others = entry.get("confounded_with") or ()
    return any(same(other, injected) for other in others for injected in truth["injected"])


def trial_score(
    truth: Mapping[str, Any],
    found: Sequence[Entry],
    unobservable: Sequence[Entry],
    errors: Mapping[str, float | None],
) -> dict[str, Any]:
    """Return the score of one set.

    Args:
        truth: As for ``acceptable``.
        found: The entries ``effects`` of diagnosis.json.
        unobservable: The entries ``unobservable`` of diagnosis.json.
        errors: ``before``, ``after`` and ``floor``, mean position errors [mm] over the same unseen poses, base aligned; None without an answer. The
            floor is the noise-limited error, which ``study.blind_trials.stratified_run`` defines. ``told``, which may be left out, is the error of a
            calibration that is told the causes.

    Returns:
        These entries, True or False unless stated otherwise:

        - ``clean``: every injected effect is named, and all entries are acceptable.
        - ``missed``: an injected effect is neither named nor listed as unobservable, and no unattributed structure is reported; or nothing is found
          although a cause without a name was injected.
        - ``wrong``, ``wrong_sure``, ``wrong_noise``: there is a wrong name; one with a confidence of ``SURE`` or more; one that is a variance
          component.
        - ``unattributed``: unmodelled structure is reported.
        - ``sure_structure``: it is reported with a confidence of ``SURE`` or more, although it is not acceptable.
        - ``fair``: a cause without a name was injected, and an acceptable name is given.
        - ``flaw_unseen``: scanner or surface have systematic errors, and no entry describes them.
        - ``worse``, ``much_worse``: ``after_over_before`` exceeds ``WORSE`` or ``MUCH_WORSE``.
        - ``after_over_before``, ``after_over_floor``: ratios of the errors, infinite without an answer.
        - ``after_over_told``, ``told_over_floor``: the same, NaN where there is no calibration that is told the causes.
    """
    injected = truth["injected"]
    wrong = [
        e for e in found if e["name"] != UNATTRIBUTED and not acceptable(e, truth) and not listed(e, truth)
    ]
    not_acceptable = [e for e in found if not acceptable(e, truth)]
    named = [any(same(e, i) for e in found) for i in injected]
    hidden = [any(u["name"] == i["name"] and same_target(u, i) for u in unobservable) for i in injected]
    unattributed = any(e["name"] == UNATTRIBUTED for e in found)
    no_name = [i for i in injected if i["name"] == "unknown"]
    nothing_said = bool(no_name) and not found
    missed = nothing_said or any(
        not n and not h for n, h, i in zip(named, hidden, injected, strict=True) if i not in no_name
    )
    told = errors.get("told") is not None
    sure = [e for e in wrong if (e.get("confidence") or 0.0) >= SURE]
    return {
        "clean": not not_acceptable and all(named),
        "missed": missed and not (unattributed and not no_name),
        "wrong": bool(wrong),
        "wrong_sure": bool(sure),
        "wrong_noise": any(e["name"] in NOISES for e in wrong),
        "unattributed": unattributed,
        "sure_structure": any(
            e["name"] == UNATTRIBUTED and (e.get("confidence") or 0.0) >= SURE and not acceptable(e, truth)
            for e in found
        ),
        "fair": bool(no_name) and any(e["name"] != UNATTRIBUTED and acceptable(e, truth) for e in found),
        "flaw_unseen": bool(flaws(truth))
        and not any(e["name"] in (*flaws(truth), UNATTRIBUTED) for e in found),
        "worse": _ratio(errors, "after", "before") > WORSE,
        "much_worse": _ratio(errors, "after", "before") > MUCH_WORSE,
        "after_over_before": _ratio(errors, "after", "before"),
        "after_over_floor": _ratio(errors, "after", "floor"),
        "after_over_told": _ratio(errors, "after", "told") if told else float("nan"),
        "told_over_floor": _ratio(errors, "told", "floor") if told else float("nan"),
    }


def _ratio(errors: Mapping[str, float | None], above: str, below: str) -> float:
    """Return the ratio of two of the errors; infinite if one is missing."""
    a, b = errors.get(above), errors.get(below)
    return float("inf") if a is None or not b else a / b


def answers(truth: Mapping[str, Any], found: Sequence[Entry]) -> list[dict[str, Any]]:
    """Return ``{name, of, confidence, right}`` for each entry that has a name; ``right`` says whether it is acceptable.

    ``of`` is ``component`` for a variance component, else ``effect``.
    """
    return [
        {
            "name": e["name"],
            "of": "component" if e["name"] in NOISES else "effect",
            "confidence": e.get("confidence"),
            "right": acceptable(e, truth),
        }
        for e in found
        if e["name"] != UNATTRIBUTED
    ]
