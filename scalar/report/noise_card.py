"""Sentences and the section of the report on a variance component: what scatters, by how much, and whether it is random."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.diagnosis.fit.variance_components import JITTER, VarianceComponent, whitening_for
from scalar.effects.flexible.first_steps import first_steps
from scalar.report import unseen_words, words
from scalar.report.residual_pictures import draw_scatter
from scalar.sensors import kind_of
from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis

REPEAT_POSES = (
    "Come back to a dozen poses ten times each, some near and some stretched out: an error that belongs to a pose, as of a hose or a loose mount, "
    "is the same at each visit; random errors of the joints are not, and grow with the reach; errors of the sensor do not grow with it."
)
WAIT = (
    "Wait at each pose until the arm has settled, then log the angles and measure. If the controller can also record the commanded angles, "
    "record them as qc1, qc2 ..., and calibrate with them."
)
COMPARE_WITH_DATA_SHEET = (
    "Compare this scatter with the repeatability on the arm's data sheet, and have brakes and gears checked if it is larger; "
    "repeated measurements of a pose average it out."
)
SEVERAL_SCANS = (
    "Check that the sensor is mounted firmly and has warmed up, and take several {measurement}s at each pose: their mean has "
    "a smaller error."
)

PLACES = {"sensor": "the place of the sensor on the flange", "base": "the place of the base"}
SCATTER = "scatter without a certain cause"
SURE = 0.8  # confidence: a cause with less has to be confirmed before anything is repaired


def noise_clause(diagnosis: Diagnosis) -> str:
    """Return what the likeliest variance component shows, as a clause."""
    if diagnosis.exceeds_any_repeatability:
        return "the poses scatter by more than the repeatability of any arm, and no known effect explains it"
    if diagnosis.depends_on:
        along = words.columns_in_words(diagnosis.depends_on)
        return f"there is structure that no known effect explains, which varies with {along}"
    if diagnosis.noise_place is not None:
        where = PLACES.get(diagnosis.noise_place) or words.columns_in_words([diagnosis.noise_place])
        return f"the poses scatter as if {where} alone erred, afresh at each pose, and no known effect explains it"
    if diagnosis.noise_is_doubtful:
        return f"whole {_measurement(diagnosis)}s scatter by more than the noise of their points, and these data do not show what causes it"
    if _along_the_move(diagnosis):
        return (
            "the arm was measured, or its angles were logged, before it stood still and at another moment in each pose, so the poses scatter "
            "along the last move"
        )
    if diagnosis.noise[0].name == JITTER:
        sure = diagnosis.noise_confidence >= SURE
        doubt = (
            ""
            if sure
            else ", or an error that belongs to each pose scatters the poses alike, as that of a hose does"
        )
        return f"the joints come back to a pose only up to a random error{doubt}"
    return f"each {_measurement(diagnosis)} as a whole has a random error"


def noise_size(diagnosis: Diagnosis) -> str:
    """Return how large the likeliest variance component is, with its unit."""
    best = diagnosis.noise[0]
    return f"{words.angle(best.std) if best.name == JITTER else words.length(best.std)} standard deviation"


def _sizes(component: VarianceComponent) -> list[tuple[str, float, float]]:
    """Return the name, value and standard error of each size of a component [rad or m]."""
    found = [("standard deviation", component.std, component.std_error)]
    if component.along_move:
        found.append(("of it along the last move", component.along_move, component.along_move_error))
    return found


def noise_advice(diagnosis: Diagnosis) -> list[str]:
    """Return sentences on what to do about the likeliest variance component, the first step first."""
    if diagnosis.component_is_no_noise:
        return first_steps(diagnosis.depends_on) or [REPEAT_POSES]
    entry = diagnosis.noise_entry()
    if len(entry["confounded_with"]) or entry["confidence"] < SURE:
        return [REPEAT_POSES]
    if _along_the_move(diagnosis):
        return [WAIT]
    if diagnosis.noise[0].name == JITTER:
        return [COMPARE_WITH_DATA_SHEET]
    return [SEVERAL_SCANS.format(measurement=_measurement(diagnosis))]


def noise_card(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the entry of the report on the likeliest variance component."""
    best = diagnosis.noise[0]
    entry = diagnosis.noise_entry()
    unit, unit_name = (DEG, "° in each joint") if best.name == JITTER else (MM, "mm")
    residual = diagnosis.after.linearised()[0][: len(best.covariance) * best.covariance.shape[1]]
    rows = residual.reshape(len(best.covariance), -1)
    white = np.einsum("nij,nj->ni", whitening_for(best), rows)
    pick = diagnosis.after.residuals.measurement.shift_rows
    near = [words.title(c["name"], c["target"]) for c in entry["confounded_with"]]
    clause = noise_clause(diagnosis)
    return {
        "title": SCATTER
        if diagnosis.noise_is_doubtful
        else words.title(entry["name"], {}, diagnosis.depends_on),
        "text": clause if diagnosis.component_is_no_noise else f"{clause}, which no correction removes",
        "is_noise": True,
        "described_as": "",
        "size": noise_size(diagnosis),
        "p_value": words.chance(best.p_value),
        "option": "",  # a random error is nothing that a calibration frees
        "sure": words.confident(entry["confidence"]),
        "limit": diagnosis.noise_limit,
        "chosen": unseen_words.share(entry, diagnosis),
        "before": None,
        "after": None,
        "seen": None,
        "table": {
            "head": ("coefficient", "value", "±", "unit"),
            "rows": [
                (name, words.number(value / unit), words.number(error / unit, 2), unit_name)
                for name, value, error in _sizes(best)
            ],
        },
        "pictures": [
            draw_scatter(rows[:, pick].ravel(), white[:, pick].ravel(), not diagnosis.component_is_no_noise)
        ],
        "confounded": {"names": words.listed(near, "or"), "poses": ""} if near else None,
    }


def _along_the_move(diagnosis: Diagnosis) -> bool:
    """Return whether the poses scatter mostly along the last move."""
    best = diagnosis.noise[0]
    return best.along_move > best.repeatability


def _measurement(diagnosis: Diagnosis) -> str:
    return "scan" if kind_of(diagnosis.dataset).scans else "measurement"
