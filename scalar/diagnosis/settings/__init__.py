"""The thresholds of the diagnosis in one frozen object: each with its unit, its meaning, and its source or the reason for its size.

A file holds the groups of one stage. The thresholds of the estimator, gross errors among them, are a part of the object. What belongs to one
effect (where its candidates stand, how large it usually is) is said in that effect's own file. Grids of what is tried are no thresholds: a
finer one finds the same, more slowly.
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
        estimation: Gross errors, sufficiency, identifiability, fits.
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
