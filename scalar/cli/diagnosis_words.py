"""The answer of ``scalar diagnose`` on the terminal, in about ten lines."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from math import inf
from typing import Any

from scalar.cli.calibration_words import lines_on_scanner_and_planes
from scalar.diagnosis.fit.partial_residuals import FittedView
from scalar.diagnosis.naming.finding import UNATTRIBUTED
from scalar.diagnosis.result import Diagnosis
from scalar.effects.command_line import named_effects
from scalar.effects.registry import module_of
from scalar.estimation.misfit import lacks_something
from scalar.report import words
from scalar.report.diagnosed_workspace import before_and_after_in_words
from scalar.report.excess_words import (
    SCATTER_OF_WHAT,
    cause_of_excess,
    more_than_instrument,
    unexplained_excess,
)
from scalar.report.few_poses import few_poses
from scalar.report.opening import verdict_on_effects, verdict_on_structure
from scalar.report.pose_numbers import with_pose_numbers
from scalar.report.scale_words import scale_in_words
from scalar.report.shipped_words import shipped_sentences
from scalar.report.unmeasured_words import unmeasured_sentence
from scalar.report.unseen_words import unseen_sentences

_UNOBSERVABLE_SHOWN = 4
_EFFECTS_NAMED = 8
_CONFOUNDED_NAMED = 3  # effects from which the data do not distinguish a finding
_POSES_NAMED = 5  # poses set aside that are named one by one
_COEFFICIENTS_SHOWN = 3
# For terminals that show only ASCII.
_RAISED = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
_POWER = re.compile(rf"(\d × )?10([{_RAISED}]+)")
_PLAIN = str.maketrans({"−": "-", "±": "+-", "°": "deg", "²": "2", "×": "x", "“": '"', "”": '"'})


def describe_diagnosis(diagnosis: Diagnosis) -> str:
    """Return what was found, in about ten lines."""
    entry = diagnosis.to_mapping()
    lines = [
        f"{diagnosis.dataset.name}: {_verdict(diagnosis)}",
        *(f"  check the set-up: {suspicion['sentence']}" for suspicion in diagnosis.setup),
        *_lines_on_effects(diagnosis, entry["effects"]),
        *_line_on_option(diagnosis),
        *_lines_on_errors(diagnosis, entry),
        *_lines_on_scales(diagnosis),
        *_lines_on_what_is_left_out(entry),
    ]
    return with_pose_numbers(in_ascii("\n".join(lines)), diagnosis.dataset)


def in_ascii(text: str) -> str:
    """Return a text for terminals that show only ASCII, powers of ten as in ``1.2e-7``."""

    def power(match: re.Match[str]) -> str:
        mantissa = match[1][0] if match[1] else "1"
        return f"{mantissa}e{match[2].translate(str.maketrans(_RAISED, '-0123456789'))}"

    return _POWER.sub(power, text).translate(_PLAIN)


def _verdict(diagnosis: Diagnosis) -> str:
    """Return in a clause whether the model lacks something."""
    if diagnosis.verdict == UNATTRIBUTED:
        return f"the residual holds {verdict_on_structure(diagnosis)}"
    if diagnosis.verdict == "effect":
        return verdict_on_effects(diagnosis) if diagnosis.findings else "only random errors found"
    summary = diagnosis.calibration_after.summary
    if lacks_something(summary):
        cause = cause_of_excess(diagnosis)
        return f"no effect found: the residual is {summary['misfit']:.1f} times what the noise explains, because of {cause}"
    if beyond := more_than_instrument(diagnosis):
        return f"no effect found, but {beyond}"
    return "no effect found: these data show nothing that the model lacks"


def _lines_on_effects(diagnosis: Diagnosis, entries: list[dict[str, Any]]) -> Iterator[str]:
    """Yield the findings: their names with sizes and confidences, and what they are confounded with.

    Args:
        diagnosis: Whose findings are stated.
        entries: Of ``effects`` in diagnosis.json. Those of the findings with a name come first, in their order.
    """
    # The findings without a name share one entry.
    indices = [i for i, finding in enumerate(diagnosis.findings) if finding.has_name]
    found = diagnosis.calibration_found
    view = FittedView.of(diagnosis.after, found.free, found.covariance)
    for k, entry in enumerate(entries[:_EFFECTS_NAMED]):
        size, sign, limit = "", "", ""
        if k < len(indices):
            i = indices[k]
            sign, limit = diagnosis.findings[i].effect.sign_in_words, diagnosis.findings[i].limit
            if len(entry["coefficients"]) > _COEFFICIENTS_SHOWN:
                size = _size_of_many(diagnosis, i, view)
        elif diagnosis.noise and entry["name"] == diagnosis.noise[0].name:
            limit = diagnosis.noise_limit
        yield from _lines_on_effect(entry, size, sign, diagnosis)
        if limit:
            yield f"    its confidence is no larger because {limit}"
    if len(entries) > _EFFECTS_NAMED:
        yield f"  and {len(entries) - _EFFECTS_NAMED} more"
    if entries:
        yield f"  {words.CONFIDENCE}"


def _lines_on_effect(entry: Mapping[str, Any], size: str, sign: str, diagnosis: Diagnosis) -> Iterator[str]:
    """Yield the lines on one entry.

    Args:
        entry: Of ``effects`` in diagnosis.json.
        size: How large the effect is in all, for one with many coefficients; else empty.
        sign: What the sign of its coefficients means, if they are shown without it; else empty.
        diagnosis: Whose findings without a name are described at the entry that they share.
    """
    unattributed = entry["name"] == UNATTRIBUTED
    title = words.title(entry["name"], entry["target"], entry.get("depends_on", ()))
    sure = "" if unattributed else f"; confidence {words.confident(entry['confidence'])}"
    yield f"  {title}{size}{_sizes(entry, sign)}{sure}"
    for like in entry.get("most_like", ()):
        name = words.quoted(words.title(like["name"], like["target"]))
        why = _why_doubtful(diagnosis, like)
        reason = f", no more because {why}" if why else ""
        yield f"    it resembles {name}, a name with a confidence of {words.confident(like['confidence'])}{reason}"
    if unattributed:
        for description in [f.effect.described_as for f in diagnosis.flexible_terms]:
            yield f"    described by {description}, which proves no cause"
    if entry["confounded_with"]:
        near = [words.title(c["name"], c["target"]) for c in entry["confounded_with"]]
        n_more = len(near) - _CONFOUNDED_NAMED
        more = [f"{n_more} more"] if n_more > 0 else []
        yield f"    these data do not distinguish it from {words.listed(near[:_CONFOUNDED_NAMED] + more, 'or')}"


def _why_doubtful(diagnosis: Diagnosis, like: Mapping[str, Any]) -> str:
    """Return the rule that lowered the confidence in a doubtful name, an entry of ``most_like``, as a clause; empty if none did."""
    if diagnosis.noise_is_doubtful and like["name"] == diagnosis.noise[0].name:
        return diagnosis.noise_limit
    of_name = [f for f in diagnosis.findings if f.doubtful and f.effect.name == like["name"]]
    return next((f.limit for f in of_name if f.effect.target == like["target"]), "")


def _line_on_option(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield the option with which ``scalar calibrate`` estimates the effects that were found; nothing without such effects."""
    effects = [finding.effect for finding in diagnosis.findings]
    if option := named_effects(effects):
        modules = {module_of(effect) for effect in effects} - {None}
        own = "".join(f" --effects-module {module}.py" for module in sorted(map(str, modules)))
        yield f"  --effects {option}{own} lets 'scalar calibrate' estimate these effects with all of their coefficients"


def _lines_on_errors(diagnosis: Diagnosis, entry: Mapping[str, Any]) -> Iterator[str]:
    """Yield the errors before and after, and which model is shipped; ``entry`` is the content of diagnosis.json."""
    residual = entry["residual"]
    before, after = residual["before"]["held_out_rms_mm"], residual["after"]["held_out_rms_mm"]
    beyond = diagnosis.verdict == "no_effect" and more_than_instrument(diagnosis)
    scatter = "a scatter like that of these measurements" if beyond else "noise alone"
    yield (
        f"  error on held-out poses {before:.4f} -> {after:.4f} mm RMS; "
        f"{scatter} would leave {residual['floor_mm']:.4f} mm"
    )
    workspace = before_and_after_in_words(diagnosis)
    for sentence in [
        *([SCATTER_OF_WHAT] if beyond else []),
        *([workspace] if workspace else []),
        *unexplained_excess(diagnosis),
        *few_poses(diagnosis),
        *unseen_sentences(diagnosis, entry),
        unmeasured_sentence(entry),
        *shipped_sentences(diagnosis),
    ]:
        yield f"  {sentence}"


def _lines_on_scales(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield which scale the data do not show, that of all lengths or that of the scanner, and which directions the planes do not show."""
    calibration = diagnosis.calibration_after
    if scale := scale_in_words(calibration):
        yield f"  no length is known in these data: every length is relative to {scale}"
    yield from lines_on_scanner_and_planes(calibration)


def _lines_on_what_is_left_out(entry: Mapping[str, Any]) -> Iterator[str]:
    """Yield which poses and points were set aside, and which effects the data cannot show; ``entry`` is the content of diagnosis.json."""
    outliers = entry["outliers"]
    if outliers["poses"] or outliers["points"]:
        yield f"  set aside: {set_aside_in_words(outliers)}"
    if unknown := outliers["direction_unknown"]:
        poses = f"pose{'s' if len(unknown) > 1 else ''} {words.listed([str(pose) for pose in unknown])}"
        yield f"  left out: {poses}: how the joints came there is not known (no pose before is recorded), and what was found depends on it"
    if entry["unobservable"]:
        titles = list(dict.fromkeys(words.title(s["name"], s["target"]) for s in entry["unobservable"]))
        more = len(titles) - _UNOBSERVABLE_SHOWN
        shown = titles[:_UNOBSERVABLE_SHOWN] + ([f"{more} more (see the report)"] if more > 0 else [])
        yield f"  unobservable in these data: {words.listed(shown)}"


def set_aside_in_words(outliers: Mapping[str, Any]) -> str:
    """Return the poses that were set aside, the first of them by their numbers, and how many points."""
    poses, mislabelled, points = outliers["poses"], outliers["mislabelled"], outliers["points"]
    parts: list[str] = []
    if poses:
        numbers = ", ".join(str(pose) for pose in poses[:_POSES_NAMED])
        more = f" and {len(poses) - _POSES_NAMED} more" if len(poses) > _POSES_NAMED else ""
        other = f" ({len(mislabelled)} on another plane than stated)" if mislabelled else ""
        parts.append(f"pose{'s' if len(poses) > 1 else ''} {numbers}{more}{other}")
    if points:
        parts.append(f"{points} point{'s' if points > 1 else ''}")
    return " and ".join(parts)


def _size_of_many(diagnosis: Diagnosis, i: int, view: FittedView) -> str:
    """Return how large finding i is in all at the measured poses, for one with many coefficients; may be empty."""
    effect = diagnosis.after.effects[i]
    size = effect.size(effect.pictures(view))
    return ", " + size.replace("°", " deg") if size else ""


def _sizes(entry: Mapping[str, Any], sign: str) -> str:
    """Return the coefficients of an effect for a line: all if there are few, else the most certain one.

    Args:
        entry: Of ``effects`` in diagnosis.json.
        sign: What the sign of the coefficients means, if they are shown without it.
    """
    shown = list(entry["coefficients"].items())
    if len(shown) > _COEFFICIENTS_SHOWN:
        shown = sorted(shown, key=lambda c: -abs(c[1]["value"]) / (c[1]["std"] or inf))[:1]
    rows = [words.coefficient(name, abs(c["value"]) if sign else c["value"], c["std"]) for name, c in shown]
    texts = [f"{name} {value} ± {std} {unit}" for name, value, std, unit in rows]
    if sign:
        texts[-1] += f" ({sign})"
    rest = len(entry["coefficients"]) - len(shown)
    return (": " + ", ".join(texts) if texts else "") + (f", and {rest} more coefficients" if rest else "")
