"""The thresholds of the estimator in one frozen object: each with its unit, its meaning, and its source or the reason for its size.

A threshold decides which points and poses are gross errors, which data suffice, which parameters are fixed, or when a fit is done. Constants of an
algorithm that decide nothing (how many terms a basis has, how many rounds a search) stay in the file of that algorithm. "Chosen" says that no
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
        "chosen: any two points lie on a line, so that three have to agree before two others can be called wrong",
    )
    corrupted_share: float = setting(
        1.0 / 3.0, "of a scan's points", "a scan with more of its points off its line is set aside whole",
        "chosen: least absolute deviations tolerate about a third of wrong points",
    )  # fmt: skip
    line_breakdown: float = setting(
        3.0, "1", "a scan's line has broken down if the standard deviation of its kept points exceeds that of their densest third by more than "
        "this factor", "simulated: the factor is 1.0 for normal errors and 1.5 for Laplace's law and Student's with three degrees of freedom, "
        "where at most one scan in eight exceeds 3; with a line that stray points led astray it is 3 to 200",
    )  # fmt: skip
    pose_sigmas: float = setting(
        10.0, "robust standard deviations", "a pose farther than this off the fit is set aside",
        "chosen: far beyond what effects do, since an effect must never be set aside as an outlier",
    )  # fmt: skip
    least_pose_error: float = setting(
        1.0 * MM, "m", "a pose nearer than this to the fit is never set aside",
        "chosen: linear accuracy of an uncalibrated arm is better than 0.65 mm (ABB IRB 1600: Slamani, Nubiola and Bonev, "
        "Industrial Robot 39, 2012), so that the errors of an arm are never set aside",
    )  # fmt: skip
    late_sigmas: float = setting(
        5.0, "robust standard deviations", "with effects modelled, a pose farther than this off the fit is set aside, if similar poses are not",
        "chosen: the largest of 3,000 normal distances is 3.6, and what the model lacks shows at similar poses too",
    )  # fmt: skip
    least_late_error: float = setting(
        0.2 * MM, "m", "a pose nearer than this to the fit is never set aside, even once effects are modelled",
        "chosen: twice the repeatability of a large arm (ISO 9283 values of data sheets are 0.02 to 0.1 mm)",
    )  # fmt: skip
    similar_poses: int = setting(
        6, "poses", "this many neighbours of a pose along each joint, and in the order of acquisition, are looked at before it is set aside late",
        "chosen: fewer are all off by chance, more reach beyond what a narrow structure moves",
    )  # fmt: skip
    similar_ratio: float = setting(
        2.0, "1", "a pose stays if the median distance of these neighbours is larger than that of all poses by more than this factor",
        "chosen: three of six normal distances exceed it once in thirty thousand",
    )  # fmt: skip
    coarse_pose_error: float = setting(
        20.0 * MM, "m", "a pose nearer than this is kept while the arm is still nominal",
        "chosen: a nominal arm and a rough sensor pose cause errors of several millimetres",
    )  # fmt: skip
    label_ratio: float = setting(
        0.2, "1", "a pose is mislabelled where another plane is nearer than this share of its own distance",
        "chosen: a plane is hardly five times nearer by chance",
    )  # fmt: skip
    core_share: float = setting(
        0.6,
        "of a plane's poses",
        "that are trusted at first",
        "chosen: least trimmed squares needs more than half",
    )
    most_set_aside: float = setting(
        0.45, "of the poses", "with more poses (or scans) set aside, it cannot be decided which are right",
        "the breakdown point of any such estimate is one half; a little less is taken, since the planes have unequal numbers of poses",
    )  # fmt: skip
    most_late: float = setting(
        0.02, "of the poses", "if more of them stand out once effects are modelled, the effects are taken to be incomplete, and none is set aside",
        "chosen: few gross errors hide behind effects, and many are a sign of a missing effect",
    )  # fmt: skip
    most_apart: float = setting(
        0.05, "of the poses", "the same where none of the other poses comes half as far as those that stand out",
        "chosen: a missing effect enlarges many residuals to different degrees, and gross errors stand apart; in a simulated campaign of 170 poses, "
        "the four that cleaning had left increased the error of others from 0.15 to 0.70 mm",
    )  # fmt: skip
    contiguous_run: int = setting(
        4, "poses", "this many or more successive poses of a plane that are all off are a change of the set-up, not outliers",
        "chosen: with one pose in ten off, four in a row come once in ten thousand",
    )  # fmt: skip
    run_by_chance: float = setting(
        0.05,
        "runs",
        "a run is a change only if scattered outliers would form fewer than this many runs of its length in the whole set",
        "the usual five per cent",
    )
    heavy_tail: float = setting(
        2.0, "1", "with a larger ratio of root mean square to median of the poses' distances, gross errors may have distorted the fit",
        "a chi law of two degrees of freedom has a ratio of 1.2",
    )  # fmt: skip


@dataclass(frozen=True)
class SufficiencySettings:
    """Which data suffice for a model."""

    least_span: float = setting(
        float(np.sin(5 * DEG)), "1", "least singular value of the planes' normals",
        "chosen: planes that lean less are parallel ones, put up askew, and a third is missing. In 50 simulated workcells with 3 to 10 degrees "
        "the standard errors were right, and no arm was worse than by its data sheet",
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
        "chosen: no effect on an arm causes an error of a centimetre; a wrong label or a wrong pose does",
    )  # fmt: skip
    equations_for_setup: float = setting(
        2.0, "equations for each unknown of sensor and target", "with fewer, not even the maker's tolerance makes a fit possible",
        "chosen: with 1.2 to 1.6, fits of simulated scans ended in wrong optima, centimetres off; with 2 none did",
    )  # fmt: skip


@dataclass(frozen=True)
class IdentifiabilitySettings:
    """Which parameters the poses identify, and what is fixed because of it."""

    null_tolerance: float = setting(
        1e-8, "of the largest singular value", "a direction below it is not observed at all",
        "the square root of the rounding error; for perfect measurements, only rounding keeps such a singular value from zero",
    )  # fmt: skip
    still: float = setting(
        STILL, "rad", "a joint that moves less than this is still",
        "chosen: a tenth of a degree, by which a joint may yield under load while its brake is on",
    )  # fmt: skip
    span_tolerance: float = setting(
        0.05,
        "1",
        "a parameter is fixed only if this much of its part in the null space is independent of those already fixed",
        "chosen: a twentieth of a unit vector",
    )
    condition_slack: float = setting(
        30.0, "1", "factor by which the smallest singular value may be smaller with the preferred set of fixed parameters than with the "
        "rank-revealing one",
        "chosen: costs one and a half digits, so that the fixed parameters are those whose values are conventions",
    )  # fmt: skip
    plausible_length: float = setting(
        5e-3, "m", "how far a length may be from the data sheet (1 sigma), if the data do not determine it",
        "chosen: an arm that differs by more is another arm; absolute errors of uncalibrated arms are a few millimetres",
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
        "with fewer, the residual is not used to judge whether the model fits",
        "a standard deviation from ten of them has a standard error of a quarter",
    )
    typical_link: float = setting(
        0.3e-3, "m, or rad", "how far lengths, and angles between axes, are from the data sheet (1 sigma), before anything is known of the arm",
        "chosen: castings machined to tenths of a millimetre, over links of about a metre; corrections published for industrial arms are of "
        "that size",
    )  # fmt: skip
    typical_zero: float = setting(
        1e-3, "rad", "the same for the zeros of the joints", "chosen: a witness mark is set to a twentieth of a degree"
    )  # fmt: skip
    typical_count: float = setting(
        6.0, "corrections", "the typical size of lengths and angles counts as much as this many corrections of the arm itself",
        "chosen: as many as a six-axis arm has of each, so that an unusual arm soon outweighs them; the typical zero counts as one, since zeros are "
        "often wrong by degrees",
    )  # fmt: skip
    prior_matters: float = setting(
        10.0, "1", "the priors of the data sheet are left out if, in every direction, the standard error is smaller than the prior standard "
        "deviation by more than this factor", "a prior then lowers no variance by more than 1 %: nothing would be gained",
    )  # fmt: skip
    prior_decides: float = setting(
        0.5, "of the prior standard deviation", "a parameter whose standard error exceeds this is reported as kept near the data sheet",
        "chosen: the data sheet then gives a quarter or more of the information on it",
    )  # fmt: skip
    settled_weight: float = setting(
        0.05, "1", "the weights of the priors are final once the logarithm of none of them changes by more",
        "chosen: a prior's standard deviation is known less well than that"
    )  # fmt: skip


@dataclass(frozen=True)
class FitSettings:
    """When a fit is done, and which results are refused."""

    settled_step: float = setting(
        0.02, "standard deviations", "the weights are final once computing them anew moves the optimum by less",
        "chosen: negligible beside the standard errors"
    )  # fmt: skip
    unseen_share: float = setting(
        3e-3, "of a column's length", "a coefficient of an effect is fixed at zero if less of its column remains with those before it projected out",
        "chosen: its standard error would be over three hundred times as large as without the other parameters",
    )  # fmt: skip
    misfit_p_value: float = setting(
        1e-3,
        "1",
        "if the noise alone would give so large a residual with a smaller probability, the model lacks something",
        "the usual one in a thousand",
    )
    largest_length_change: float = setting(
        0.5,
        "m",
        "a fit in which a length is farther from its nominal value is refused",
        "chosen: no arm differs from its data sheet by so much",
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
    """Return settings with another value of one field.

    Args:
        settings: The settings, or a group of them.
        path: Names of the groups and of the field, from the outside in.
        value: The value.
        name: The whole name, for the message.

    Raises:
        ValueError: There is no such field.
    """
    first, *rest = path
    part = getattr(settings, first) if first in {item.name for item in fields(settings)} else None
    if part is None or is_dataclass(part) != bool(rest):
        raise ValueError(f"'{name}' is no threshold")
    return replace(settings, **{first: _with(part, rest, value, name) if rest else value})
