"""The thresholds of the diagnosis in one frozen object: each with its unit, its meaning, and its source or the reason for its size.

Each file of this folder holds the groups of thresholds of one stage. The thresholds of the estimator, for example those of gross errors, are the
group ``estimation``. Numbers that belong to one effect (the grid of its candidates, its natural size) are in that effect's own file. Grids of
candidates are not thresholds, because a finer grid gives the same results, only more slowly.
``snakemake sensitivity`` halves and doubles every threshold and tabulates what changes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from scalar.diagnosis.settings.answers import (
    NamingSettings,
    ObservabilitySettings,
    OuterSplitSettings,
    ShippedFitSettings,
)
from scalar.diagnosis.settings.many_terms import FlexibleTermSettings, SpectrumSettings
from scalar.diagnosis.settings.noise import AutocorrelationSettings, VarianceComponentSettings
from scalar.diagnosis.settings.selection import (
    HoldOutSettings,
    ScoreTestSettings,
    SelectionSettings,
    SubsetSearchSettings,
)
from scalar.estimation.settings import DEFAULTS as ESTIMATION_DEFAULTS
from scalar.estimation.settings import EstimationSettings

__all__ = [
    "DEFAULTS",
    "AutocorrelationSettings",
    "FlexibleTermSettings",
    "HoldOutSettings",
    "NamingSettings",
    "ObservabilitySettings",
    "OuterSplitSettings",
    "ScoreTestSettings",
    "SelectionSettings",
    "Settings",
    "ShippedFitSettings",
    "SpectrumSettings",
    "SubsetSearchSettings",
    "VarianceComponentSettings",
]


@dataclass(frozen=True)
class Settings:
    """All thresholds of a diagnosis.

    Attributes:
        estimation: Gross errors, whether the data suffice, identifiability, and fits.
        score_test: The score of a candidate without a refit.
        hold_out: Held-out poses, and when their errors differ.
        selection: When an effect is added, replaced or dropped.
        subset_search: The comparison of whole sets of effects.
        flexible_terms: Flexible terms for unmodelled structure.
        spectrum: When a joint has all orders at once.
        variance_components: Random errors of whole poses.
        autocorrelation: When residuals of neighbouring poses are autocorrelated.
        observability: When an effect is unobservable.
        naming: When a finding is given a name.
        shipped_fit: Which fit is written to ``after.json``.
        outer_split: Which findings the runs without a part of the poses confirm.
    """

    estimation: EstimationSettings = ESTIMATION_DEFAULTS
    score_test: ScoreTestSettings = field(default_factory=ScoreTestSettings)
    hold_out: HoldOutSettings = field(default_factory=HoldOutSettings)
    selection: SelectionSettings = field(default_factory=SelectionSettings)
    subset_search: SubsetSearchSettings = field(default_factory=SubsetSearchSettings)
    flexible_terms: FlexibleTermSettings = field(default_factory=FlexibleTermSettings)
    spectrum: SpectrumSettings = field(default_factory=SpectrumSettings)
    variance_components: VarianceComponentSettings = field(default_factory=VarianceComponentSettings)
    autocorrelation: AutocorrelationSettings = field(default_factory=AutocorrelationSettings)
    observability: ObservabilitySettings = field(default_factory=ObservabilitySettings)
    naming: NamingSettings = field(default_factory=NamingSettings)
    shipped_fit: ShippedFitSettings = field(default_factory=ShippedFitSettings)
    outer_split: OuterSplitSettings = field(default_factory=OuterSplitSettings)


DEFAULTS = Settings()
