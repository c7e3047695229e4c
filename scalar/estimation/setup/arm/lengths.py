"""Whether the lengths of an arm came out where its table of joints has them: a wrong unit, a mistyped number, another robot."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model
from scalar.estimation.setup.arm.far_lengths import arms_in_words, most_of_a_link
from scalar.estimation.setup.length_units import is_ratio_of_units
from scalar.estimation.setup.planes.known_planes import base_moved_to
from scalar.estimation.setup.suspicion import Suspicion
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.se3 import Array
from scalar.geometry.standard_dh import as_stated
from scalar.robots import arms_in_proportion
from scalar.sensors import kind_of
from scalar.units import MM

LENGTH_UNIT = "length_unit"  # as a suspicion names a wrong unit of all lengths
STRETCHED = "stretched_lengths"  # as a suspicion says that all lengths are a little too long
ROBOT = "robot"  # as a suspicion names a table of joints that is not that of the measured arm
LEAST_SLIP = 5 * MM  # a length that is farther from the table may be mistyped, if the others are near it
SLIP = 5.0  # times the median change of the other lengths: with a larger one, a length is said to be mistyped
_LONG = 30 * MM  # the ratio of fitted to nominal length counts of links that are longer than this
SIGMAS = 5.0  # standard errors that a change has to exceed: a fit may end far away in a parameter that is hardly determined
SCALE_SPREAD = 0.2  # relative: if the ratios of fitted to nominal lengths scatter by less, they have a common factor, and a unit is wrong
# Relative, chosen: by how much a factor may differ from the ratio of two units and be taken for it.
_UNIT_SLIP = 0.1
_LEAST_STRETCHED = 3  # chosen: lengths that have to agree on a factor near 1
_LEAST_STRETCH = 0.01  # relative, chosen: no arm's lengths are all wrong by so much
_STRETCH_SPREAD = 0.25  # of the stretch, chosen: no single length may be farther from it
LEAST_SCALE = 1.3  # of that factor: a smaller one is not taken for a wrong unit


def lengths_off(dataset: Dataset, model: Model, std: Array, fixed_length: str | None) -> list[Suspicion]:
    """Return a suspicion if a length changed too much: of a unit if all lengths changed by about the same factor, else of the largest change."""
    nominal, fitted = dataset.robot.geometry, model.robot.geometry
    errors = std[model.blocks["geometry"]].reshape(nominal.shape)
    rows = [k for k, kind in enumerate(GEOMETRY) if kind in LENGTHS]
    change = np.where(np.isfinite(errors), fitted - nominal, 0.0)[rows]
    zeros = np.outer([GEOMETRY[k] == "d" for k in rows], dataset.robot.slides)
    change[zeros] = 0.0  # the zero of a travel depends on the reference run, and may be anywhere
    limit = most_of_a_link(dataset.robot)
    clear = np.abs(change) > SIGMAS * np.nan_to_num(errors[rows])
    off = (np.abs(change) > limit) & clear
    long = np.isfinite(errors[rows]) & (np.abs(nominal[rows]) > _LONG)
    ratios = fitted[rows][long] / nominal[rows][long]
    if fixed_length is None and (stretched := _stretched(ratios)) is not None:
        more, than = ("longer", "large") if stretched > 1 else ("shorter", "small")
        return [
            Suspicion(
                STRETCHED,
                kind_of(dataset).format.measured_in,
                f"all links come out {100 * abs(stretched - 1):.2g} % {more} than dataset.yaml has them: are the measurements too {than} by this "
                "factor (the stated size of a board or of a probe, the scale of a camera or a scanner), or is this the table of another robot?",
            )
        ]
    if not off.any():
        return _mistyped_length(dataset, model, change, clear, _in_proportion(model, fixed_length))
    factor = _common_factor(ratios)
    if factor is not None:
        return [
            Suspicion(
                LENGTH_UNIT,
                kind_of(dataset).format.measured_in,
                f"all links come out {factor:.3g} times as long as dataset.yaml has them: {_what_to_look_at(factor)}"
                f"{arms_in_words(model.robot, '; or at the robot:')}",
            )
        ]
    return [_another_robot(dataset, model, change, off, fixed_length)]


def _what_to_look_at(factor: float) -> str:
    """Return as a clause what may make all lengths wrong by a factor: a unit, or, if no two units have this ratio, a robot of another size."""
    if is_ratio_of_units(factor, float(np.log1p(_UNIT_SLIP))):
        return "look at the unit of the measurements and of the table of joints (millimetres, inches, metres)"
    size = "smaller" if factor > 1 else "larger"
    return (
        f"no two units differ by this factor; look whether this is the table of a {size} robot of the same type, or whether the measurements are too "
        f"{'large' if factor > 1 else 'small'} (the stated size of a board, the scale of a camera)"
    )


def _stretched(ratios: Array) -> float | None:
    """Return the factor, near 1, by which all lengths come out longer than the table has them; None if they do not agree on one.

    Args:
        ratios: ``(k,)``, fitted over nominal, of the long lengths.
    """
    typical = float(np.median(ratios)) if len(ratios) >= _LEAST_STRETCHED else 1.0
    stretch = abs(typical - 1.0)
    if not _LEAST_STRETCH < stretch < LEAST_SCALE - 1.0:
        return None
    return typical if np.max(np.abs(ratios - typical)) < _STRETCH_SPREAD * stretch else None


def _common_factor(ratios: Array) -> float | None:
    """Return the factor by which all lengths are wrong, from the ratios of fitted to nominal lengths; None if they have none in common."""
    typical = float(np.median(ratios)) if len(ratios) else 1.0
    common = (
        len(ratios) > 1
        and typical > 0
        and max(typical, 1 / typical) > LEAST_SCALE
        and float(np.median(np.abs(ratios - typical))) < SCALE_SPREAD * typical
    )
    return typical if common else None


def _another_robot(
    dataset: Dataset, model: Model, change: Array, off: Array, fixed_length: str | None
) -> Suspicion:
    """Return the suspicion that the table of joints is wrong in the length that changed most, or that it is that of another robot.

    Args:
        dataset: What was measured.
        model: Where the fit ended.
        change: ``(2, joints)``, a and d: how far each comes out from the table [m]; 0 where the data do not show it.
        off: The same shape: whether it is too far.
        fixed_length: The length that is fixed, and to which all others are relative; or None.
    """
    lengths = [kind for kind in GEOMETRY if kind in LENGTHS]
    k, j = np.unravel_index(int(np.argmax(np.abs(change))), change.shape)
    name = as_stated(f"{lengths[k]}_{j + 1}", dataset.robot)
    fixed = None if fixed_length is None else as_stated(fixed_length, dataset.robot)
    which = f"{name} or {fixed}, to which all lengths are relative here," if fixed else name
    known = base_moved_to(dataset, model) if j == 0 else ()
    elsewhere = f"is {' or '.join(known)} not where it is declared known, " if known else ""
    others = [
        f"{as_stated(f'{lengths[m]}_{i + 1}', dataset.robot)} {abs(change[m, i]) / MM:.0f} mm"
        for m, i in sorted(np.argwhere(off).tolist(), key=lambda at: -abs(change[at[0], at[1]]))
        if (m, i) != (k, j)
    ]
    as_well = f" ({', '.join(others)} as well)" if others else ""
    return Suspicion(
        ROBOT,
        name,
        f"{name} comes out {abs(change[k, j]) / MM:.0f} mm from the table of joints{as_well}: is {which} wrong there, {elsewhere}or is "
        f"this another robot than the one that was measured?{arms_in_words(model.robot) or _in_proportion(model, fixed_length)}",
    )


def _in_proportion(model: Model, fixed_length: str | None) -> str:
    """Return a sentence that names the arms of the library that are the measured arm in another size, where the data show no length; else nothing."""
    found = [] if fixed_length is None else arms_in_proportion(model.robot)
    if not found:
        return ""
    named = " or ".join(f"{arm.maker} {arm.model} ('{arm.name}' of the library)" for _, arm in found)
    return (
        f" Such data show the proportions of an arm and not its size, and those between its axes are the ones of {named}, whose lengths are "
        f"{found[0][0]:.3g} times as large: if that arm was measured, all lengths here are wrong by this factor"
    )


def _mistyped_length(
    dataset: Dataset, model: Model, change: Array, clear: Array, in_proportion: str
) -> list[Suspicion]:
    """Return a suspicion if one length alone is far from the table, though not farther than frames of other makers' tables may be.

    Args:
        dataset: What was measured.
        model: Where the fit ended.
        change: ``(2, joints)``, a and d: how far each comes out from it [m]; 0 where the data do not show it.
        clear: The same shape: whether the change exceeds its standard error by far.
        in_proportion: A sentence on arms of another size that it may be; empty if there are none.
    """
    k, j = np.unravel_index(int(np.argmax(np.abs(change))), change.shape)
    others = np.abs(np.delete(change.ravel(), k * change.shape[1] + j))
    others = others[others > 0]
    typical = float(np.median(others)) if len(others) > 1 else np.inf
    if not clear[k, j] or abs(change[k, j]) < max(LEAST_SLIP, SLIP * typical):
        return []
    lengths = [kind for kind in GEOMETRY if kind in LENGTHS]
    nominal = dataset.robot.geometry[[GEOMETRY.index(kind) for kind in lengths]]
    name = as_stated(f"{lengths[k]}_{j + 1}", dataset.robot)
    known = base_moved_to(dataset, model) if j == 0 else ()
    elsewhere = f"is target plane {' or '.join(known)} not where it is declared known, " if known else ""
    return [
        Suspicion(
            ROBOT,
            name,
            f"{name} comes out {abs(change[k, j]) / MM:.1f} mm {'longer' if change[k, j] * nominal[k, j] >= 0 else 'shorter'} than the table of "
            f"joints has it ({nominal[k, j] / MM:.6g} mm), where half of the other lengths differ by less than {max(typical, 0.1 * MM) / MM:.1f} mm: "
            f"{elsewhere}is it mistyped there, or is the table that of another version of this robot? The calibration states what the measurements "
            "show."
            f"{arms_in_words(model.robot).removesuffix('.') or in_proportion}",
        )
    ]
