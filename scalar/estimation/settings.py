"""The thresholds of the estimator in one frozen object: each with its unit, its meaning, and its source or the reason for its size.

A threshold decides: which points and poses are gross errors, which data suffice, which parameters are fixed, when a fit is done. Shapes of an
algorithm that decide nothing (how many terms a basis has, how many rounds a search) stay where the algorithm is. "Chosen" says that no
source gives the number; the study ``snakemake sensitivity`` says how much depends on it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np

from scalar.data.moves import STILL
from scalar.estimation.documented_setting import setting
from scalar.estimation.noise_settings import WithinScanNoiseSettings
from scalar.units import DEG, MM

Settings = TypeVar("Settings")


@dataclass(frozen=True)
class GrossErrorSettings:
    """What is a gross error: a point off its own scan, a pose off all others, a wrong label."""

    point_sigmas: float = setting(
        5.0, "robust standard deviations", "a point farther than this off its scan's line is set aside",
        "chosen: one normal point in two million is lost",
    )  # fmt: skip
    least_point_error: float = setting(
        2e-4, "m", "a point nearer than this to its scan's line is never set aside",
        "chosen: twice the usual noise of a line laser, so that a very quiet scan keeps its points",
    )  # fmt: skip
    least_points: int = setting(
        5,
        "points",
        "a shorter scan has no outlying points",
        "chosen: two points make a line, three must agree against two",
    )
    corrupted_share: float = setting(
        1.0 / 3.0, "of a scan's points", "a scan with more of its points off its line is set aside whole",
        "chosen: least absolute deviations forgive about a third of wrong points",
    )  # fmt: skip
    line_breakdown: float = setting(
        3.0, "1", "standard deviation of a scan's kept points about their line over that of their densest third beyond which the line has "
        "broken down", "simulated: points of a normal law have 1.0, of Laplace's and of Student's with three degrees of freedom 1.5, and at "
        "most one scan in eight of these has more than 3; where stray points led the line astray, it is 3 to 200",
    )  # fmt: skip
    pose_sigmas: float = setting(
        10.0, "robust standard deviations", "a pose farther than this off the fit is set aside",
        "chosen: far beyond what effects do, since an effect must never be set aside as an outlier",
    )  # fmt: skip
    least_pose_error: float = setting(
        1.0 * MM, "m", "a pose nearer than this to the fit is never set aside",
        "chosen: linear accuracy of an uncalibrated arm is better than 0.65 mm (ABB IRB 1600: Slamani, Nubiola and Bonev, "
        "Industrial Robot 39, 2012), so that what an arm does stays in",
    )  # fmt: skip
    coarse_pose_error: float = setting(
        20.0 * MM, "m", "a pose nearer than this is kept while the arm is still nominal",
        "chosen: a nominal arm and a rough sensor pose make several millimetres",
    )  # fmt: skip
    label_ratio: float = setting(
        0.2, "1", "a pose is mislabelled where another plane is nearer than this share of its own distance",
        "chosen: five times nearer is no chance",
    )  # fmt: skip
    core_share: float = setting(
        0.6,
        "of a plane's poses",
        "that are trusted at first",
        "chosen: least trimmed squares needs more than half",
    )
    most_set_aside: float = setting(
        0.45, "of the poses", "with more set aside, nothing can be said of which are right",
        "the breakdown point of any such estimate is one half; a little less, for the planes share the poses unevenly",
    )  # fmt: skip
    most_late: float = setting(
        0.02, "of the poses", "with more that stand out only once effects are known, the effects are not yet right",
        "chosen: few gross errors hide behind effects, many are a sign of a missing effect",
    )  # fmt: skip
    contiguous_run: int = setting(
        4, "poses", "so many successive poses of a plane that are all off are a change, not outliers",
        "chosen: with one pose in ten off, four in a row come once in ten thousand",
    )  # fmt: skip
    run_by_chance: float = setting(
        0.05,
        "runs",
        "expected number of runs as long that scattered outliers would make",
        "the usual five per cent",
    )
    heavy_tail: float = setting(
        2.0, "1", "root mean square over median of the poses' distances beyond which gross errors may have dragged the fit",
        "a chi law of two degrees of freedom has 1.2",
    )  # fmt: skip


@dataclass(frozen=True)
class SufficiencySettings:
    """Which data suffice for a model."""

    least_span: float = setting(
        float(np.sin(10 * DEG)), "1", "least singular value of the planes' normals",
        "chosen: planes nearer than ten degrees to parallel amplify noise sixfold",
    )  # fmt: skip
    farthest_guess: float = setting(
        60 * DEG, "rad", "an initial guess of a normal may be this far off the plane that the points lie on",
        "chosen: half-way between an initial guess and the normal of another wall",
    )  # fmt: skip
    least_width: float = setting(
        1e-3, "of a plane's longest extent", "points on a narrower strip lie on a line", "chosen: no scan of a plane is as narrow"
    )  # fmt: skip
    least_width_sigmas: float = setting(
        5.0, "standard deviations of the sensor", "points on a narrower strip lie on a line", "chosen: noise widens a line by two or three"
    )  # fmt: skip
    gross_error: float = setting(
        10.0 * MM, "m", "a pose farther off than this after a fit is a gross error",
        "chosen: no effect on an arm makes a centimetre, a wrong label or a wrong pose does",
    )  # fmt: skip
    equations_for_setup: float = setting(
        2.0, "equations for each unknown of sensor and target", "with fewer, not even the maker's tolerance makes a fit possible",
        "chosen: with 1.2 to 1.6 of them, fits of simulated scans ended in other optima, centimetres off; with 2 none did",
    )  # fmt: skip


@dataclass(frozen=True)
class IdentifiabilitySettings:
    """Which parameters the poses identify, and what is fixed because of it."""

    null_tolerance: float = setting(
        1e-8, "of the largest singular value", "a direction below it is not observed at all",
        "the root of the rounding error: perfect measurements leave nothing but rounding",
    )  # fmt: skip
    still: float = setting(
        STILL, "rad", "a joint that moves less than this is still",
        "chosen: a tenth of a degree, which a loaded brake gives",
    )  # fmt: skip
    span_tolerance: float = setting(
        0.05,
        "1",
        "what a parameter must add to those already fixed to be worth fixing",
        "chosen: a twentieth of a direction",
    )
    condition_slack: float = setting(
        30.0, "1", "how much worse than the rank-revealing set the conventional one may be conditioned",
        "chosen: one and a half digits, for parameters whose place is a convention",
    )  # fmt: skip
    plausible_length: float = setting(
        5e-3, "m", "how far a length may be from the data sheet (1 sigma), where the data do not say",
        "chosen: an arm off by more is another arm; absolute errors of uncalibrated arms are a few millimetres",
    )  # fmt: skip
    plausible_angle: float = setting(
        0.0175, "rad", "the same for an angle", "chosen: a degree, as far as a joint's zero is set by hand"
    )
    plausible_sensor_place: float = setting(
        0.05, "m", "the same for the sensor on the flange", "chosen: measured with a ruler"
    )
    plausible_sensor_turn: float = setting(
        0.2, "rad", "the same for its orientation", "chosen: judged by eye"
    )
    plausible_target: float = setting(10.0, "m or rad", "the same for the target", "nothing is known of it")
    enough_to_judge: int = setting(
        10,
        "degrees of freedom",
        "for the residual to say how large the noise is",
        "a standard deviation of ten is known to a quarter",
    )
    typical_link: float = setting(
        0.3e-3, "m, or rad", "how far lengths, and angles between axes, are from the data sheet (1 sigma), before the arm itself says so",
        "chosen: castings machined to tenths of a millimetre, over links of about a metre; corrections published for industrial arms are of "
        "that size",
    )  # fmt: skip
    typical_zero: float = setting(
        1e-3, "rad", "the same for the zeros of the joints", "chosen: a witness mark is set to a twentieth of a degree"
    )  # fmt: skip
    typical_count: float = setting(
        6.0, "corrections", "number of them that the typical lengths and angles count as, when they are pooled with those of the arm",
        "chosen: as many as a six-axis arm has of each, so that an arm that differs soon outweighs them; zeros, often degrees off, count as one",
    )  # fmt: skip
    prior_matters: float = setting(
        10.0, "1", "the priors of the data sheet are left out where every direction's standard error is smaller than its prior standard "
        "deviation by more", "a prior then lowers no variance by more than 1 %: nothing would be gained",
    )  # fmt: skip
    prior_decides: float = setting(
        0.5, "of the prior standard deviation", "a parameter whose standard error exceeds this is said to be kept near the data sheet",
        "chosen: a quarter of what is known of it comes from the data sheet then",
    )  # fmt: skip
    settled_weight: float = setting(
        0.05, "1", "a weight of the priors that changes by less is the last", "chosen: a prior's size is not known as well"
    )  # fmt: skip


@dataclass(frozen=True)
class FitSettings:
    """When a fit is done, and what it may not say."""

    settled_step: float = setting(
        0.02, "standard deviations", "a new whitening that moves the optimum by less is the last", "chosen: invisible beside the standard errors"
    )  # fmt: skip
    unseen_share: float = setting(
        3e-3, "of a column's length", "a coefficient of an effect with less left, given everything else, is fixed at zero",
        "chosen: its standard error is three hundred times that of a well-placed one",
    )  # fmt: skip
    misfit_p_value: float = setting(
        1e-3,
        "1",
        "a residual less likely than this under the noise says that the model lacks something",
        "the usual one in a thousand",
    )
    largest_length_change: float = setting(
        0.5,
        "m",
        "a length that ran farther from its nominal value is refused",
        "chosen: no workshop builds such an arm",
    )
    largest_angle_change: float = setting(
        1.5, "rad", "the same for an angle", "chosen: a quarter turn is another convention"
    )


@dataclass(frozen=True)
class EstimationSettings:
    """All thresholds of the estimator."""

    gross_errors: GrossErrorSettings = GrossErrorSettings()
    sufficiency: SufficiencySettings = SufficiencySettings()
    identifiability: IdentifiabilitySettings = IdentifiabilitySettings()
    fit: FitSettings = FitSettings()
    within_scan_noise: WithinScanNoiseSettings = field(default_factory=WithinScanNoiseSettings)


DEFAULTS = EstimationSettings()


def documentation(settings: Any, prefix: str = "") -> dict[str, dict[str, Any]]:
    """Return value, unit, meaning and reason of every threshold by its dotted name, ``gross_errors.point_sigmas``."""
    found: dict[str, dict[str, Any]] = {}
    for item in fields(settings):
        value = getattr(settings, item.name)
        if is_dataclass(value):
            found |= documentation(value, f"{prefix}{item.name}.")
        else:
            found[prefix + item.name] = {"value": value, **item.metadata}
    return found


def changed(settings: Settings, values: Mapping[str, Any]) -> Settings:
    """Return settings with other values of some thresholds, by the names that ``documentation`` gives them.

    Raises:
        ValueError: A name is that of no threshold.
    """
    for name, value in values.items():
        settings = _with(settings, name.split("."), value, name)
    return settings


def _with(settings: Any, path: list[str], value: Any, name: str) -> Any:
    first, *rest = path
    part = getattr(settings, first) if first in {item.name for item in fields(settings)} else None
    if part is None or is_dataclass(part) != bool(rest):
        raise ValueError(f"'{name}' is no threshold")
    return replace(settings, **{first: _with(part, rest, value, name) if rest else value})
