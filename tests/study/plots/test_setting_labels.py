"""The paper's figure of the thresholds shows words, not names of the code."""

import pandas as pd
from study.plots.setting_labels import LABELS, label_of

from scalar.diagnosis.settings import DEFAULTS
from scalar.estimation.settings import documentation


def test_every_threshold_of_the_figure_has_a_label(request):
    """Each threshold that changes an answer in the committed summary is called by words, and no two by the same ones."""
    table = pd.read_csv(request.config.rootpath / "paper/summaries/sensitivity/settings.csv")
    shown = table.loc[table[["changed_halved", "changed_doubled"]].sum(axis=1) > 0, "setting"]
    assert set(shown) <= set(LABELS)
    assert len(set(LABELS.values())) == len(LABELS)


def test_labels_are_of_thresholds_that_exist():
    """No label outlives its threshold."""
    assert set(LABELS) <= set(documentation(DEFAULTS))


def test_a_threshold_without_a_label_keeps_its_name():
    """The name is then shown in words."""
    assert label_of("estimation.fit.settled_step") == "fit: settled step"
