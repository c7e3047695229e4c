"""The score of a stratified set: the columns of the table of blind trials, of which several may apply to one set.

An entry of a diagnosis is *acceptable* where it is an injected effect at its place, or a fair description of something else that
is truly there: a bowed target plane, a crooked lens, or a cause without a name of its own that has one nearby (``FAIR``). It is
*listed* where an injected effect stands in its ``confounded_with``. Everything else that has a name is a *wrong name*. Components of
the scanner's own noise stand in ``noise.components``, are no effects, and are not judged here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from study.blind_trials.score import NOISES, SURE, UNATTRIBUTED, Entry, same, same_target

WORSE, MUCH_WORSE = 1.05, 1.2  # after over before, mean error over unseen poses
FAIR: Mapping[str, tuple[str, ...]] = {
    "air_conditioning": ("thermal_drift",),  # links do grow
    "sawtooth_growth": ("thermal_drift",),
    "encoder_interpolation": ("joint_ripple", "pose_jitter"),  # 512 waves a turn look random at random angles
    "giving_floor": ("base_compliance",),  # it does tilt under the moment, beyond a threshold
    "late_trigger": ("pose_lag",),
    "two_slope_gear": ("joint_compliance", "torque_compliance"),
    "vibration": ("pose_lag", "pose_jitter"),
}
"""By unknown cause, the names that describe it fairly if they name its joint or none."""


def acceptable(entry: Entry, truth: Mapping[str, Any]) -> bool:
    """Return whether an entry of a diagnosis describes something that is truly there.

    Args:
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
    """Return the names that describe what scanner and surface do wrong, beside noise."""
    surface, scanner = truth.get("surface") or {}, truth.get("scanner") or {}
    names: tuple[str, ...] = ("plane_bow",) if surface.get("bow_m") else ()
    return names + (("sensor_map", "range_distortion") if scanner.get("linearity_m") else ())


def _joints(entry: Entry) -> set[int]:
    target = entry.get("target") or {}
    return set(target.get("joints") or ([target["joint"]] if "joint" in target else []))


def listed(entry: Entry, truth: Mapping[str, Any]) -> bool:
    """Return whether an injected effect stands among those that an entry is confounded with."""
    others = entry.get("confounded_with") or ()
    return any(same(other, injected) for other in others for injected in truth["injected"])


def trial_score(
    truth: Mapping[str, Any],
    found: Sequence[Entry],
    unobservable: Sequence[Entry],
    errors: Mapping[str, float | None],
) -> dict[str, Any]:
    """Return the columns of one set.

    Args:
        truth: As for ``acceptable``.
        found, unobservable: Of diagnosis.json.
        errors: ``before``, ``after`` and ``floor``, mean position errors [mm] over the same unseen poses, base aligned. The floor
            is the noise-limited error: that of the same scene, with the same poses, surfaces and draws of noise, without what
            was injected, calibrated.
    """
    injected = truth["injected"]
    wrong = [
        e for e in found if e["name"] != UNATTRIBUTED and not acceptable(e, truth) and not listed(e, truth)
    ]
    alarm = [e for e in found if not acceptable(e, truth)]
    named = [any(same(e, i) for e in found) for i in injected]
    hidden = [any(u["name"] == i["name"] and same_target(u, i) for u in unobservable) for i in injected]
    unattributed = any(e["name"] == UNATTRIBUTED for e in found)
    no_name = [i for i in injected if i["name"] == "unknown"]
    nothing_said = bool(no_name) and not found
    missed = nothing_said or any(
        not n and not h for n, h, i in zip(named, hidden, injected, strict=True) if i not in no_name
    )
    sure = [e for e in wrong if (e.get("confidence") or 0.0) >= SURE]
    return {
        "clean": not alarm and all(named),
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
    }


def _ratio(errors: Mapping[str, float | None], above: str, below: str) -> float:
    """Return a ratio of errors; infinite where there is no answer."""
    a, b = errors.get(above), errors.get(below)
    return float("inf") if a is None or not b else a / b


def answers(truth: Mapping[str, Any], found: Sequence[Entry]) -> list[dict[str, Any]]:
    """Return a row for each entry that has a name: its stated confidence, and whether it is acceptable."""
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
