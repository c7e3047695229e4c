"""A diagnosis and its file: the effects that were found, their confidence, what is confounded with them, and what is unobservable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from scalar.data.dataset import Dataset
from scalar.data.io.atomic import plain
from scalar.diagnosis.accuracy.expected_errors import shipped_entry
from scalar.diagnosis.accuracy.stated_errors import held_out, unseen, where_unmeasured
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import JITTER, VarianceComponent
from scalar.diagnosis.held_out.hold_out import HeldOutErrors
from scalar.diagnosis.held_out.outer_split import OuterSplit
from scalar.diagnosis.naming.confidence import confidence
from scalar.diagnosis.naming.finding import UNATTRIBUTED, Finding, unattributed_entry
from scalar.diagnosis.naming.grounds import Grounds
from scalar.diagnosis.naming.limits_of_noise import limit_of_noise
from scalar.diagnosis.naming.observability import Unobservable
from scalar.diagnosis.noise.noise_floor import noise_entry, noise_floor
from scalar.diagnosis.scoring.ranking import Scored, candidate_entries
from scalar.diagnosis.shipping.shipped_fit import BY_COMPONENT, ShippedFit
from scalar.estimation.gross_errors import Cleaned
from scalar.estimation.result import Calibration
from scalar.estimation.setup.tables.computed_positions import COMPUTED
from scalar.units import MM

FORMAT = "scalar-diagnosis/2"


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Which effects the rigid model of a dataset lacks.

    Attributes:
        dataset: The dataset as read.
        cleaned: The dataset without its gross errors, and what was set aside.
        before, after: The states without effects and with all findings, which unconfirmed effects may follow (``shipped.unconfirmed``).
        held_out_before: Held-out errors without effects.
        calibration_before, calibration_found: The calibrations of these states.
        calibration_after: The calibration that is shipped as ``after.json``.
        shipped: Which fit is shipped, how it weights the poses, and what decided that.
        findings: The effects that were found, in the order in which they were added.
        noise: Variance components of whole poses that were identified, the likeliest first; only the first is reported.
        noise_grounds: The grounds of the first, or None if there is none.
        depends_on: Columns along which the residuals are autocorrelated, or between whose few values they differ. A variance component is then no
            noise, and is reported as unattributed.
        unobservable: Effects that leave no residual in these data.
        ranking: The candidates with the most evidence on the residual without effects, best first.
        not_confirmed: Effects that too few of the outer split's runs selected: they are no findings.
        noise_place: The one place at which a random error explains the scatter better (``q4``, ``sensor``, ``base``), or None. If there is one, a
            variance component is no noise either.
        outer: Answers of the diagnoses without a part of the poses, or None without an outer split.
        halves: Answers of the diagnoses of one half of the poses each, or None if they were not needed (``two_halves``).
    """

    dataset: Dataset
    cleaned: Cleaned
    before: FittedState
    after: FittedState
    held_out_before: HeldOutErrors
    calibration_before: Calibration
    calibration_found: Calibration
    calibration_after: Calibration
    shipped: ShippedFit
    findings: tuple[Finding, ...]
    noise: tuple[VarianceComponent, ...]
    noise_grounds: Grounds | None
    depends_on: tuple[str, ...]
    unobservable: tuple[Unobservable, ...]
    ranking: tuple[Scored, ...]
    not_confirmed: tuple[Finding, ...] = ()
    noise_place: str | None = None
    outer: OuterSplit | None = None
    halves: OuterSplit | None = None

    @property
    def _ships_geometry_alone(self) -> bool:
        """Return whether ``after.json`` is the fit without effects; the errors of runs that shipped effects say nothing about it then."""
        return not self.shipped_state.effects and self.shipped.fit != BY_COMPONENT

    @property
    def ships_effects(self) -> bool:
        """Return whether ``after.json`` contains effects, so that held-out poses have taken part in their selection."""
        return bool(self.findings) and not self.shipped.without_effects

    @property
    def shipped_state(self) -> FittedState:
        """Return the fit that is shipped."""
        return self.before if self.shipped.without_effects else self.shipped.choice.state

    @property
    def errors_after(self) -> dict[str, float | None]:
        """Return the entry of ``diagnosis.json`` on the errors of the calibration that is shipped [mm]."""
        return {
            **held_out(
                self.calibration_after, self.shipped.held_out, self.halves if self.ships_effects else None
            ),
            **unseen(self.outer, 0 if self._ships_geometry_alone else 1, self.calibration_after),
        }

    @property
    def setup(self) -> list[dict[str, Any]]:
        """Return what the fit without effects finds doubtful in the set-up, and whether positions were computed, which effects may hide."""
        before = self.calibration_before.summary["setup"]
        after = [s for s in self.calibration_after.summary["setup"] if s["what"] == COMPUTED]
        return before if any(s["what"] == COMPUTED for s in before) else [*before, *after]

    @property
    def unobservable_alone(self) -> tuple[Unobservable, ...]:
        """Return the unobservable effects without those confounded with a named finding, which are listed with that finding.

        With the finding in the model, an effect that is confounded with it leaves no residual either. Those that may be present together with the
        finding, and not in its place, are returned.
        """
        rivals = {e.title for finding in self.findings if finding.has_name for e in finding.confounded_with}
        return tuple(e for e in self.unobservable if e.may_accompany or e.effect.title not in rivals)

    @property
    def verdict(self) -> str:
        """Return ``no_effect``, ``effect`` or ``unattributed``."""
        if any(not finding.has_name for finding in self.findings) or self.noise_without_a_name:
            return UNATTRIBUTED
        return "effect" if self.findings or self.reported_noise else "no_effect"

    @property
    def confirmed_noise(self) -> tuple[VarianceComponent, ...]:
        """Return the variance components, unless the outer split does not confirm them."""
        share = self._noise_selected_in
        least = self.after.settings.outer_split.least_selected
        return self.noise if share is None or share >= least else ()

    @property
    def reported_noise(self) -> tuple[VarianceComponent, ...]:
        """Return the variance components that are reported: none if there are flexible terms, since they may be a remainder of that structure."""
        return () if self.flexible_terms else self.confirmed_noise

    @property
    def noise_confidence(self) -> float:
        """Return the estimated probability that the likeliest variance component has its name rightly."""
        assert self.noise_grounds is not None
        most, _ = self._limit_of_noise
        result = min(most, confidence(self.noise_grounds, self.noise[0].name))
        return result if self.confirmed_noise else min(result, self._noise_selected_in or 0.0)

    @property
    def noise_limit(self) -> str:
        """Return why the confidence in the likeliest variance component is no larger, as a clause; empty if no rule lowered it."""
        assert self.noise_grounds is not None
        most, reason = self._limit_of_noise
        return reason if most < confidence(self.noise_grounds, self.noise[0].name) else ""

    @property
    def _limit_of_noise(self) -> tuple[float, str]:
        """The largest confidence that the rules allow the likeliest variance component, and the reason as a clause."""
        unnamed = any(not finding.has_name for finding in self.findings)
        return limit_of_noise(self.after, self.noise[0], self.halves, beside_structure=unnamed)

    @property
    def noise_is_doubtful(self) -> bool:
        """Return whether a variance component is reported whose confidence is below ``settings.naming.least_confidence``."""
        return (
            bool(self.reported_noise) and self.noise_confidence < self.after.settings.naming.least_confidence
        )

    @property
    def noise_without_a_name(self) -> bool:
        """Return whether a variance component is reported as unattributed, because it is no noise or its name is doubtful."""
        return bool(self.reported_noise) and (self.component_is_no_noise or self.noise_is_doubtful)

    @property
    def _noise_selected_in(self) -> float | None:
        """Return the share of the outer split's runs that identified the likeliest variance component; None if it is not known."""
        if self.outer is None or not self.outer.answers or not self.noise:
            return None
        return self.outer.noise_selected_in(self.noise[0].name)

    @property
    def flexible_terms(self) -> list[Finding]:
        """Return the flexible terms among the findings."""
        return [finding for finding in self.findings if finding.effect.flexible]

    @property
    def component_is_no_noise(self) -> bool:
        """Return whether the variance component is no noise: larger than any arm's repeatability, autocorrelated, or an error of one place."""
        no_noise = self.exceeds_any_repeatability or bool(self.depends_on) or self.noise_place is not None
        return bool(self.confirmed_noise) and no_noise

    @property
    def exceeds_any_repeatability(self) -> bool:
        """Return whether the poses scatter by more than any arm's repeatability, so that the scatter has another, unknown cause."""
        return (
            bool(self.noise)
            and self.noise[0].name == JITTER
            and self.noise[0].repeatability > self.after.settings.variance_components.worst_repeatability
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return the content of ``diagnosis.json``."""
        effects = [finding.to_mapping() for finding in self.findings if finding.has_name]
        not_confirmed = [finding.to_mapping() for finding in self.not_confirmed]
        if self.noise and not self.confirmed_noise and not self.flexible_terms:
            not_confirmed.append(self.noise_entry())
        if self.reported_noise and not self.noise_without_a_name:
            effects.append(self.noise_entry())
        if self.verdict == UNATTRIBUTED:
            effects.append(self._unattributed_entry())
        outliers = [*self.cleaned.outlier_poses, *(pose for pose, _ in self.cleaned.mislabelled_poses)]
        shipped, after = shipped_entry(self, self.halves), self.errors_after
        stated, expected = (after["held_out_rms_mm"], after["unseen_rms_mm"]), shipped["expected_error_mm"]
        mapping = {
            "format": FORMAT,
            "verdict": self.verdict,
            "effects": effects,
            "unobservable": [s.to_mapping() for s in self.unobservable_alone],
            "outliers": {
                "poses": sorted(outliers),
                "points": self.cleaned.points,
                "mislabelled": [
                    {"pose": pose, "lies_on": plane} for pose, plane in self.cleaned.mislabelled_poses
                ],
                "direction_unknown": sorted(self.cleaned.direction_unknown),
            },
            "setup": [
                {key: suspicion[key] for key in ("what", "where", "rms_before_mm", "rms_after_mm")}
                for suspicion in self.setup
            ],
            "noise": noise_entry(self.after),
            "residual": {
                "before": held_out(self.calibration_before, self.held_out_before)
                | unseen(self.outer, 0, self.calibration_before),
                "after": after,
                "floor_mm": noise_floor(self.after) / MM,
            },
            "unmeasured": where_unmeasured(
                self.shipped_state, self.before, [*stated, expected["as_shipped_within_joint_limits"]]
            ),
            "shipped": shipped,
            "not_confirmed": not_confirmed,
            "outer_split": None if self.outer is None else self.outer.to_mapping(),
            "candidates": candidate_entries(self.ranking, self.before.background().sum_of_squares),
        }
        return plain(mapping)

    def _unattributed_entry(self) -> dict[str, Any]:
        """Return the one entry for all findings without a name, and for a variance component without a name."""
        component = self.noise_entry() if self.noise_without_a_name else None
        findings = [finding for finding in self.findings if not finding.has_name]
        if component and self.component_is_no_noise:
            if not findings:
                return component
            entry = unattributed_entry(findings)
            return entry | {
                "depends_on": list(dict.fromkeys([*entry["depends_on"], *component["depends_on"]]))
            }
        entry = unattributed_entry(findings, component)
        return entry | {"depends_on": entry["depends_on"] or self._joint_columns}

    @property
    def _joint_columns(self) -> list[str]:
        """Return the columns of all joints, which are stated if no test shows on which columns the structure depends."""
        return [f"q{i + 1}" for i in range(self.dataset.robot.n_joints)]

    def noise_entry(self) -> dict[str, Any]:
        """Return the entry of the likeliest variance component, under its name or, if it is no noise, as unattributed."""
        best, *others = self.noise
        settings = self.after.settings
        unit = "std_rad" if best.name == JITTER else "std_m"
        coefficients = {unit: {"value": best.std, "std": best.std_error}}
        if best.along_move:
            coefficients["along_last_move_rad"] = {"value": best.along_move, "std": best.along_move_error}
        near = [
            s
            for s in others
            if best.log_likelihood_gain - s.log_likelihood_gain
            < settings.estimation.within_scan_noise.confounded_likelihood
        ]
        share = self._noise_selected_in
        assert self.noise_grounds is not None
        entry: dict[str, Any] = {
            "name": best.name,
            "target": {},
            "coefficients": coefficients,
            "p_value": best.p_value,
            "held_out_rms_before_mm": self.shipped.rms_with_equal_weights / MM,
            "held_out_rms_after_mm": self.shipped.effects_held_out.rms / MM,
            "confounded_with": [{"name": s.name, "target": {}} for s in near],
            "confidence": self.noise_confidence,
            "grounds": self.noise_grounds.to_mapping(),
            "selected_in": share,
        }
        if self.component_is_no_noise:
            joint = [self.noise_place] if self.noise_place in self._joint_columns else []
            depends = list(self.depends_on) or joint or self._joint_columns
            entry |= {"name": UNATTRIBUTED, "confounded_with": [], "depends_on": depends, "most_like": []}
        return entry
