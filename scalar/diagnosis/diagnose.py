"""A diagnosis: what was found, how sure, what could not be told apart, what cannot be seen; to save and to report."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.io.atomic import plain
from scalar.diagnosis.autocorrelation import depends_on
from scalar.diagnosis.confidence import confidence
from scalar.diagnosis.fitted_state import State, settle
from scalar.diagnosis.forward_selection import (
    CONFOUNDED_MARGIN,
    Bank,
    Columns,
    Scored,
    bank,
    hunt,
    merged,
    rank,
    rivals,
    same_answer,
    same_place,
)
from scalar.diagnosis.harmonic_spectrum import as_whitened, has_all_orders, is_shrunk, with_spectrum
from scalar.diagnosis.hold_out import HeldOut, held_out
from scalar.diagnosis.observability import Silent, silent
from scalar.diagnosis.score_test import Background
from scalar.diagnosis.unmodelled_structure import with_unnamed
from scalar.diagnosis.variance_components import CONFOUNDED, Mixed, Spread, whitening
from scalar.effects.catalogue import effect_to_mapping
from scalar.effects.effect import Effect
from scalar.effects.unattributed import Unattributed
from scalar.estimation.conclude import conclude
from scalar.estimation.gross_errors import Cleaned, clean, clean_beside, geometry_fit
from scalar.estimation.joint_fit import fit_from
from scalar.estimation.result import Calibration
from scalar.geometry.se3 import Array
from scalar.sensors.line_laser import LineLaser
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

FORMAT = "scalar-diagnosis/1"
MAX_RANKING = 25
MAX_CLEANINGS = 3  # gross errors may hide behind effects, and effects behind gross errors
WORST_REPEATABILITY = 4e-4  # rad of each joint: 0.4 mm at arm's length, several times what the worst industrial arms are sold with


@dataclass(frozen=True, eq=False)
class Finding:
    """An effect that was found.

    Attributes:
        effect: With its coefficients.
        p_value: Of its gain beside the other effects, corrected for all that were tried.
        before, after: Held-out errors without and with it, in the order of taking.
        confounded_with: Effects that would explain the same as well.
        confidence: Chance that name and target are right.
    """

    effect: Effect
    p_value: float
    before: HeldOut
    after: HeldOut
    confounded_with: tuple[Effect, ...]
    confidence: float


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What a dataset says of what its model lacks.

    Attributes:
        dataset: As read; ``cleaned`` is what was used.
        before, after: States without effects and with all that were found.
        calibration_before, calibration_after: The same as calibrations.
        findings: In the order in which they were added.
        noise: Noise effects, the likeliest first; the first is what is reported.
        depends_on: Columns in whose order the residuals of neighbours are alike where a noise would have a name: it is none.
        silent: Effects that these data cannot show.
        ranking: Of all candidates on the residual before, best first.
    """

    dataset: Dataset
    cleaned: Cleaned
    before: State
    after: State
    held_out_before: HeldOut
    held_out_after: HeldOut
    calibration_before: Calibration
    calibration_after: Calibration
    findings: tuple[Finding, ...]
    noise: tuple[Spread, ...]
    depends_on: tuple[str, ...]
    silent: tuple[Silent, ...]
    ranking: tuple[Scored, ...]

    @property
    def verdict(self) -> str:
        """Return ``no_effect``, ``effect`` or ``unattributed``."""
        if self.spread_is_no_noise or self.unnamed:
            return "unattributed"
        return "effect" if self.findings or self.noise else "no_effect"

    @property
    def unnamed(self) -> list[Finding]:
        """Return the flexible terms among the findings."""
        return [finding for finding in self.findings if isinstance(finding.effect, Unattributed)]

    @property
    def spread_is_no_noise(self) -> bool:
        """Return whether poses spread by what is no noise: more than any arm, or alike for poses that are near one another."""
        return bool(self.noise) and (self.spread_beyond_belief or bool(self.depends_on))

    @property
    def spread_beyond_belief(self) -> bool:
        """Return whether poses spread by more than any arm's repeatability: something acts on them that no test here recognises."""
        return (
            bool(self.noise)
            and self.noise[0].name == "pose_jitter"
            and self.noise[0].std > WORST_REPEATABILITY
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return the content of ``diagnosis.json``."""
        std = self.calibration_after.std
        named = [f for f in self.findings if not isinstance(f.effect, Unattributed)]
        unnamed = self.unnamed
        effects = [self._finding(f, std) for f in named]
        # Beside structure without a name, what poses spread by is as likely the rest of that structure as a noise.
        if self.noise and not unnamed:
            effects.append(self.noise_entry())
        effects += [self._unnamed(unnamed, std)] if unnamed else []
        outliers = [*self.cleaned.outlier_poses, *(pose for pose, _ in self.cleaned.mislabelled_poses)]
        mapping = {
            "format": FORMAT,
            "verdict": self.verdict,
            "effects": effects,
            "silent": [s.to_mapping() for s in self.silent],
            "outliers": {
                "poses": sorted(outliers),
                "points": self.cleaned.points,
                "mislabelled": [
                    {"pose": pose, "lies_on": plane} for pose, plane in self.cleaned.mislabelled_poses
                ],
            },
            "noise": {
                "within_scan_mm": self.after.residuals.measurement.sigma / MM,
                "between_scans_mm": between_scans(self.after) / MM,
            },
            "residual": {
                "before": _residual(self.before, self.held_out_before),
                "after": _residual(self.after, self.held_out_after),
                "floor_mm": floor(self.after) / MM,
            },
        }
        return plain(mapping)

    def _finding(self, finding: Finding, std: Mapping[str, float]) -> dict[str, Any]:
        entry = effect_to_mapping(finding.effect, std)
        return {
            "name": entry["name"],
            "target": entry["target"],
            "coefficients": entry["coefficients"],
            "p_value": finding.p_value,
            "held_out_rms_before_mm": finding.before.rms / MM,
            "held_out_rms_after_mm": finding.after.rms / MM,
            "confounded_with": [{"name": e.name, "target": e.target} for e in finding.confounded_with],
            "confidence": finding.confidence,
        }

    def _unnamed(self, findings: list[Finding], std: Mapping[str, float]) -> dict[str, Any]:
        entry = self._finding(findings[0], std)
        entry["coefficients"] = {}
        depends = [v for f in findings for v in f.effect.depends_on]  # type: ignore[attr-defined]
        entry["depends_on"] = list(dict.fromkeys(depends))
        entry["held_out_rms_after_mm"] = findings[-1].after.rms / MM
        entry["corrected_by_flexible_term"] = True
        return entry

    def noise_entry(self) -> dict[str, Any]:
        """Return the entry of the likeliest noise effect; without a name where it is beyond belief."""
        best, *others = self.noise
        unit = "std_rad" if best.name == "pose_jitter" else "std_m"
        near = [s for s in others if best.log_likelihood_gain - s.log_likelihood_gain < CONFOUNDED]
        entry = {
            "name": best.name,
            "target": {},
            "coefficients": {unit: {"value": best.std, "std": best.std_error}},
            "p_value": best.p_value,
            "held_out_rms_before_mm": self.held_out_after.rms / MM,
            "held_out_rms_after_mm": self.held_out_after.rms / MM,
            "confounded_with": [{"name": s.name, "target": {}} for s in near],
            "confidence": confidence(best.log_likelihood_gain, [s.log_likelihood_gain for s in others]),
        }
        if self.spread_is_no_noise:
            joints = [f"q{i + 1}" for i in range(self.dataset.robot.n_joints)]
            depends = list(self.depends_on) or joints
            entry |= {"name": Unattributed.name, "confounded_with": [], "depends_on": depends}
        return entry


def _distances(state: State) -> Array:
    """Return the root mean square distance [m] of every pose, effects applied, ``(N,)``."""
    squares, counts = state.residuals.squared_distances(state.model)
    return np.sqrt(squares / counts)


def _residual(state: State, error: HeldOut) -> dict[str, float]:
    return {
        "train_rms_mm": state.residuals.rms(state.model) / MM,
        "held_out_rms_mm": error.rms / MM,
        "held_out_max_mm": error.largest / MM,
    }


def floor(state: State) -> float:
    """Return the root mean square distance [m] that the noise within scans alone would leave."""
    measurement = state.residuals.measurement
    if not isinstance(measurement, LineLaser):
        return measurement.sigma * float(np.sqrt(measurement.rows_per_pose))
    return measurement.noise_floor(state.residuals.kinematics(state.model).T_base_sensor, state.model.target)


def between_scans(state: State) -> float:
    """Return the standard deviation [m] of what a scan as a whole is off, beyond the noise of its points; zero where it is not."""
    measurement = state.residuals.measurement
    background = Background.of(*state.linearised(), state.dataset.n_poses, measurement.rows_per_pose)
    excess = max(background.variance - 1.0, 0.0)
    if not isinstance(measurement, LineLaser):
        return float(np.sqrt(excess)) * measurement.sigma
    # The first profile row is the whitened mean: its length in metres is one over the norm of the weights.
    weights = np.abs(measurement.R[:, 0, 0])
    first = np.mean(background.residual[:, 0] ** 2) - 1.0
    return float(np.sqrt(max(first, 0.0))) / float(np.sqrt(np.mean(weights**2)))


def diagnose(dataset: Dataset, progress: Callable[[str], None] = lambda stage: None) -> Diagnosis:
    """Return what a dataset says of what its model lacks.

    Args:
        dataset: What was measured.
        progress: Called with the name of each stage.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: The data cannot determine even the geometry.
    """
    progress("cleaning")
    cleaned = clean(dataset)
    for _ in range(MAX_CLEANINGS):
        model, prepared = geometry_fit(cleaned.dataset)
        before = settle(cleaned.dataset, model, prepared.free, ())
        tried = bank(cleaned.dataset)
        progress("hunting")
        found = hunt(before, tried)
        cleaner = clean_beside(cleaned, _distances(found))
        if cleaner is cleaned:
            break
        cleaned = cleaner
    ranking = rank(before, before.background(), Columns(before, tried))
    progress("looking for structure without a name")
    after = with_unnamed(found, tried)
    progress("joints that err in many orders")
    after = with_spectrum(after, tried)
    noise = tuple(after.spreads)
    findings = _findings(before, after, tried)
    progress("calibrating")
    calibration_before = conclude(
        cleaned.dataset, prepared, *fit_from(cleaned.dataset, before.model, before.free)
    )
    calibration_after = conclude(cleaned.dataset, prepared, *_final_fit(after, noise))
    # What is reported is what the calibration holds, to the last digit.
    fitted = calibration_after.model.effects
    findings = tuple(replace(f, effect=effect) for f, effect in zip(findings, fitted, strict=True))
    return Diagnosis(
        dataset=dataset,
        cleaned=cleaned,
        before=before,
        after=after,
        held_out_before=held_out(before),
        held_out_after=held_out(after),
        calibration_before=calibration_before,
        calibration_after=calibration_after,
        findings=findings,
        noise=noise,
        depends_on=tuple(depends_on(after)) if noise else (),
        silent=tuple(silent(after, [candidate for candidate, _ in tried.tried])),
        ranking=tuple(ranking[:MAX_RANKING]),
    )


def _final_fit(state: State, noise: tuple[Spread, ...]) -> Any:
    """Return the final fit of a state: on all points, or on profile rows weighted for a noise effect where there is one."""
    if not noise:
        return fit_from(state.dataset, state.model, state.free)
    residuals = state.residuals
    residuals = type(residuals)(
        Mixed(residuals.measurement, whitening(noise[0])), residuals.poses, residuals.bases, residuals.known
    )
    return fit_from(state.dataset, as_whitened(state).model, state.free, residuals)


def _findings(before: State, after: State, tried: Bank) -> tuple[Finding, ...]:
    """Return the effects of a state one by one, each with the held-out error before and after it is added."""
    found = []
    state, error = before, held_out(before)
    effects: tuple[Effect, ...] = ()
    scored = as_whitened(after)
    cols = Columns(scored, tried)
    for i, effect in enumerate(after.effects):
        effects = merged(effects, effect)
        state = settle(after.dataset, state.model, after.geometry_free, effects)
        now = held_out(state)
        own, ranking = rivals(scored, i, cols)
        ranking = [s for s in ranking if not has_all_orders(after, s.effect)]
        others = [s.evidence for s in ranking if not same_answer(s.effect, effect)]
        near = [s.effect for s in ranking if s.evidence > own.evidence - CONFOUNDED_MARGIN]
        near = [e for e in near if not same_place(e, effect) and not isinstance(effect, Unattributed)]
        if is_shrunk(effect):
            others, near = [], []
        sure = confidence(own.evidence, others)
        found.append(Finding(effect, own.p_value, error, now, tuple(near), sure))
        error = now
    return tuple(found)
