"""Compare two calibrations of one arm, as in a yearly check, or before and after a crash, a change of motor or a payload."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.comparison.arm_parameters import ArmParameters, arm_parameters, effects_of_the_arm
from scalar.comparison.beyond_chance import is_beyond_chance
from scalar.comparison.changes import ALPHA, Candidate, Change, find_changes
from scalar.comparison.disjoint_terms import DisjointTerms, effects_with_disjoint_terms
from scalar.comparison.invariants import displacement_columns, displacements, invariants
from scalar.comparison.moved import Moved
from scalar.comparison.sensor_shift import SensorShift
from scalar.comparison.stretch import Stretch, with_scale, without_scale
from scalar.comparison.unnamed_terms import UnnamedTerm, unnamed_terms
from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.effects.command_line import named_effects
from scalar.effects.parameter_names import effect_of, parameter_names
from scalar.errors import Fault, InvalidInput
from scalar.estimation.displacement import position_std
from scalar.estimation.result import Calibration
from scalar.estimation.usual_noise import noisier
from scalar.geometry.parallel_axes import near_parallel_joints
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.se3 import rotation_angle
from scalar.units import DEG, MM

FORMAT = "scalar-comparison/1"
_FIXED_IN_BOTH = "it was fixed in both"
_SAME_LENGTH, _SAME_ANGLE = 1e-6, 1e-6  # m, rad: nominal geometries that differ by more are of two arms


@dataclass(frozen=True, eq=False)
class Comparison:
    """What changed between two calibrations A and B.

    Attributes:
        arm: The arm's parameters in both.
        changes: The changes beyond chance, the surest first.
        stretch: By what share all lengths differ, if that is beyond chance: of the instruments, or of a warmer arm.
        moved: How far each change alone moves predicted positions.
        rest_p_value: p-value of the difference that the changes leave unexplained.
        alpha: Probability that any change is found where there is none.
        positions_apart: How far apart the positions are that the two calibrations predict.
        by_chance: Root mean square [m] of that distance for an arm that did not change, by both covariances.
        compared: Names of the parameters that were compared one by one; effects without common coefficients are not among them.
        disjoint_terms: Effects that both contain, but with no coefficient in common; compared by the positions that they make.
        not_compared: ``{name: reason}`` of the parameters that were not compared.
        campaign: What differs but is not of the arm: the sensor's place on the flange [mm, deg] and its kind, and the names of the arms. The standard
            error and the p-value of the place are None where the calibrations fix different parameters.
        misfits: For A and B, the ratio of residual to noise, and its p-value.
        residuals: Root mean square residuals [m] of A and B.
        noisier: 0 or 1 if A or B has a residual that is larger than the other's beyond chance while no noise is known; else None.
        effects: The effects of A and of B, as ``--effects`` of `scalar calibrate` takes them.
        unnamed: The flexible terms of A and of B, which have no name for ``--effects``.
        same_effects: The values of ``--effects`` for calibrating A and B again so that each contains the arm's effects found in either.
    """

    arm: ArmParameters
    changes: list[Change]
    stretch: Stretch | None
    moved: list[Moved]
    rest_p_value: float
    alpha: float
    positions_apart: Moved
    by_chance: float
    compared: tuple[str, ...]
    disjoint_terms: list[DisjointTerms]
    not_compared: dict[str, str]
    campaign: dict[str, Any]
    misfits: tuple[tuple[float, float], ...]
    residuals: tuple[float, float]
    noisier: int | None
    effects: tuple[str, str]
    same_effects: tuple[str, str]
    unnamed: tuple[tuple[UnnamedTerm, ...], tuple[UnnamedTerm, ...]]

    @property
    def changed(self) -> bool:
        """Return whether any compared parameter, or all of them as a whole, differ beyond chance.

        Effects without common coefficients do not count, and neither does a scale of all lengths, which the instruments may have changed.
        """
        return bool(self.changes) or self.rest_p_value < self.alpha

    @property
    def positions_changed(self) -> bool:
        """Return whether the predicted positions differ beyond chance; unlike ``changed``, also by what only one calibration contains."""
        return is_beyond_chance(self.positions_apart.rms, self.by_chance, self.alpha)

    def to_mapping(self) -> dict[str, Any]:
        """Return the content of ``comparison.json``."""
        changes = []
        for change, moved in zip(self.changes, self.moved, strict=True):
            parameters = {
                self.arm.names[i]: {"value": float(v), "std": float(s), "unit": self.arm.units[i]}
                for i, v, s in zip(change.candidate.columns, change.value, change.std, strict=True)
            }
            changes.append(
                {
                    "name": change.candidate.name,
                    "parameters": parameters,
                    "p_value": change.p_value,
                    "moves_positions": moved.to_mapping(),
                    "not_distinguished_from": [rival.name for rival in change.rivals],
                }
            )
        return {
            "format": FORMAT,
            "changed": self.changed,
            "changes": changes,
            "scale_of_all_lengths": None if self.stretch is None else self.stretch.to_mapping(),
            "rest_p_value": self.rest_p_value,
            "alpha": self.alpha,
            "positions_differ": {
                **self.positions_apart.to_mapping(),
                "by_chance_rms_mm": self.by_chance / MM,
                "beyond_chance": self.positions_changed,
            },
            "compared": list(self.compared),
            "only_in": dict(zip("AB", map(list, self.arm.only_in), strict=True)),
            "compared_by_positions": [effect.to_mapping() for effect in self.disjoint_terms],
            "not_compared": self.not_compared,
            "unnamed_terms": {
                letter: [term.to_mapping() for term in terms]
                for letter, terms in zip("AB", self.unnamed, strict=True)
            },
            "campaign": self.campaign,
        }


def compare(a: Calibration, b: Calibration, alpha: float = ALPHA) -> Comparison:
    """Return what changed in an arm from calibration A to calibration B.

    Args:
        a: The earlier calibration.
        b: The later one, of another campaign, so that its errors are independent of those of A.
        alpha: Probability that any change is found where there is none.

    Raises:
        InvalidInput: They are of different arms, or one of them states no covariance.
    """
    _check_comparable(a, b)
    arm = arm_parameters(a, b)
    compared = invariants(arm)
    found, rest = find_changes(*with_scale(arm, compared, _candidates(arm)), alpha)
    columns = displacement_columns(arm)
    changes, stretch = without_scale(arm, found, columns)
    moved = [Moved.of(columns[:, list(c.candidate.columns)] @ c.value) for c in changes]
    not_compared = dict(arm.unknown)
    for i, name in enumerate(arm.names):
        if arm.fixed_in_both[i]:
            not_compared.setdefault(name, _FIXED_IN_BOTH)
        elif not compared.response[:, i].any():
            not_compared.setdefault(
                name, "a motion of base or sensor between the campaigns would look the same"
            )
    _say_of_tilts(not_compared, arm)
    disjoint_terms = effects_with_disjoint_terms(a.model, b.model, arm, columns, alpha)
    by_positions = {name for effect in disjoint_terms for name in effect.parameters}
    for name in by_positions:
        not_compared.pop(name, None)
    return Comparison(
        arm=arm,
        changes=changes,
        stretch=stretch,
        moved=moved,
        rest_p_value=rest,
        alpha=alpha,
        positions_apart=Moved.of(displacements(a.model, b.model)),
        by_chance=position_std(columns, arm.covariance),
        compared=tuple(
            name
            for i, name in enumerate(arm.names)
            if compared.response[:, i].any() and name not in not_compared and name not in by_positions
        ),
        disjoint_terms=disjoint_terms,
        not_compared=not_compared,
        campaign=_campaign(a, b),
        misfits=(_misfit(a), _misfit(b)),
        residuals=(a.residual_rms, b.residual_rms),
        noisier=noisier(a, b),
        effects=(named_effects(a.model.effects), named_effects(b.model.effects)),
        same_effects=(_same_effects(a, b), _same_effects(b, a)),
        unnamed=(unnamed_terms(a.model), unnamed_terms(b.model)),
    )


def _same_effects(own: Calibration, other: Calibration) -> str:
    """Return ``--effects`` for one of two campaigns: its own effects, and the arm's effects of the other."""
    return named_effects(
        (*effects_of_the_arm(own.model), *effects_of_the_arm(other.model), *own.model.effects)
    )


def _misfit(calibration: Calibration) -> tuple[float, float]:
    """Return the ratio of a fit's residual to the noise and its p-value; 1 and 1 where the noise is not known."""
    ratio, p_value = (calibration.summary.get(key) for key in ("misfit", "misfit_p_value"))
    return (1.0, 1.0) if ratio is None or p_value is None else (float(ratio), float(p_value))


def _candidates(arm: ArmParameters) -> list[Candidate]:
    """Return every geometric parameter, the zeros of the joints as the common ones, and every effect with all of its terms."""
    together: dict[str, list[int]] = defaultdict(list)
    for i, name in enumerate(arm.names):
        together[effect_of(name)].append(i)
    return [Candidate(name, tuple(columns), name.startswith("theta_")) for name, columns in together.items()]


def _campaign(a: Calibration, b: Calibration) -> dict[str, Any]:
    """Return how the sensor's place on the flange differs, and the kinds of sensors and the names of the arms where they differ."""
    T = np.linalg.inv(a.model.T_flange_sensor) @ b.model.T_flange_sensor
    campaign: dict[str, Any] = SensorShift.between(a, b).to_mapping()
    if a.observes_orientation and b.observes_orientation:
        campaign["sensor_turn_deg"] = float(rotation_angle(T[None, :3, :3])[0] / DEG)
    kinds = [one.sensor["kind"] for one in (a, b)]
    if kinds[0] != kinds[1]:
        campaign["sensor_kinds"] = kinds
    if a.model.nominal.name != b.model.nominal.name:
        campaign["names"] = [a.model.nominal.name, b.model.nominal.name]
    return campaign


def _say_of_tilts(not_compared: dict[str, str], arm: ArmParameters) -> None:
    """Name the tilts that were not compared as the effect ``axis_nonparallel``, with what it takes to compare them, and no other.

    Hayati's beta itself is fixed in every calibration: what is compared, or not, is the effect on top of it, and it stands for something only where
    two axes are nearly parallel. By the rows of a standard-DH table, the beta of one axis has the number of the axis before.
    """
    contained = {
        effect.target["joint"] for effect in arm.model.effects if effect.name == AxisNonparallel.name
    }
    missing = []
    for joint in range(1, arm.model.robot.n_joints + 1):
        reason = not_compared.get(f"beta_{joint}", "")
        if joint in contained:
            not_compared.pop(f"beta_{joint}", None)
        elif reason.startswith(_FIXED_IN_BOTH):
            del not_compared[f"beta_{joint}"]
            missing += [joint] if joint in near_parallel_joints(arm.model.nominal) else []
    tilts = [AxisNonparallel(joint) for joint in missing]
    reason = f"in neither calibration; to compare it, add --effects {named_effects(tilts)} to both"
    for names in parameter_names(tilts):
        not_compared |= dict.fromkeys(names, reason)


def _check_comparable(a: Calibration, b: Calibration) -> None:
    """Raise ``InvalidInput`` if the calibrations are of different arms, or one states no standard errors."""
    one, other = a.model.nominal, b.model.nominal
    if one.n_joints != other.n_joints:
        message = f"it calibrates an arm of {other.n_joints} joints, and A one of {one.n_joints}; give two calibrations of one arm"
        raise InvalidInput(Fault("B", message))
    for k, kind in enumerate(GEOMETRY):
        bound = _SAME_LENGTH if kind in LENGTHS else _SAME_ANGLE
        off = np.abs(one.geometry[k] - other.geometry[k])
        if off.max() > bound:
            i = int(np.argmax(off))
            values = f"{other.geometry[k, i]:.6g} where A has {one.geometry[k, i]:.6g}"
            message = (
                f"it calibrates another arm: nominal {kind}_{i + 1} is {values}; "
                "give two calibrations with the same nominal geometry"
            )
            raise InvalidInput(Fault("B", message))
    for letter, calibration in zip("AB", (a, b), strict=True):
        if not calibration.free or not np.all(np.isfinite(calibration.covariance)):
            message = "it states no standard errors, so that chance cannot be judged; give what `scalar calibrate` writes"
            raise InvalidInput(Fault(letter, message))
