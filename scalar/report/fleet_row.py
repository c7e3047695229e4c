"""One line of a fleet's table: what a diagnosis found on one robot, or why its data were refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scalar.diagnosis.naming.finding import UNATTRIBUTED
from scalar.errors import ScalarError, printable
from scalar.evaluate.workspace_errors import NOMINAL, mean_over_poses
from scalar.report.diagnosed_workspace import errors_over_workspace
from scalar.report.pose_numbers import with_pose_numbers
from scalar.report.words import title
from scalar.report.workspace_map import SHIPPED
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis

COLUMNS = (
    "folder",
    "status",
    "verdict",
    "robot",
    "poses",
    "effects",
    "confidence",
    "held_out_before_mm",
    "held_out_after_mm",
    "unseen_after_mm",
    "noise_floor_mm",
    "data_sheet_error_mm",
    "after_error_mm",
    "after_error_at_most_mm",
    "outlier_poses",
    "mislabelled_poses",
    "message",
    "unsure_effects",
)
"""The columns of the table. ``status`` is the exit status of ``scalar diagnose`` for the folder alone; if it is not 0, the numbers are empty. The
errors of the data sheet and of ``after.json`` are means over the workspace; ``at_most`` is the upper end of the 95 % band. Names with less
confidence than one that is given alone are ``unsure_effects``, each with its confidence and with what the data do not distinguish from it."""


def row_of(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the line of a diagnosis, without its folder."""
    mapping = diagnosis.to_mapping()
    residual = mapping["residual"]
    effects, unsure = sure_and_unsure(mapping["effects"], diagnosis.after.settings.naming.least_confidence)
    return {
        "status": 0,
        "verdict": mapping["verdict"],
        "robot": diagnosis.dataset.robot.name,
        "poses": diagnosis.dataset.n_poses,
        "effects": with_pose_numbers("; ".join(_title(e) for e in effects), diagnosis.dataset),
        "confidence": "; ".join(f"{e['confidence']:.2f}" for e in effects),
        "held_out_before_mm": residual["before"]["held_out_rms_mm"],
        "held_out_after_mm": residual["after"]["held_out_rms_mm"],
        "unseen_after_mm": residual["after"]["unseen_rms_mm"],
        "noise_floor_mm": residual["floor_mm"],
        **_over_workspace(diagnosis),
        "outlier_poses": len(mapping["outliers"]["poses"]),
        "mislabelled_poses": len(mapping["outliers"]["mislabelled"]),
        "message": "; ".join(suspicion["sentence"] for suspicion in diagnosis.setup),
        "unsure_effects": with_pose_numbers("; ".join(_with_rivals(e) for e in unsure), diagnosis.dataset),
    }


def sure_and_unsure(
    effects: Sequence[Mapping[str, Any]], least_confidence: float
) -> tuple[list[Mapping[str, Any]], list[Mapping[str, Any]]]:
    """Return the entries that are found, and those whose own name has too little confidence.

    Structure without a name is found whatever its confidence; the names that it is most like are among the unsure ones.

    Args:
        effects: Entries of ``effects`` in diagnosis.json.
        least_confidence: With less, a name is unsure even if it is the likeliest of several that the data do not distinguish.
    """
    found = [e for e in effects if e["name"] == UNATTRIBUTED or e["confidence"] >= least_confidence]
    unsure = [e for e in effects if e not in found]
    return found, unsure + [like for e in found for like in e.get("most_like", ())]


def _title(entry: Mapping[str, Any]) -> str:
    return title(entry["name"], entry["target"], entry.get("depends_on", ()))


def _with_rivals(entry: Mapping[str, Any]) -> str:
    """Return an entry's title and confidence, and the titles of what the data do not distinguish from it."""
    rivals = "".join(f" or {_title(rival)}" for rival in entry.get("confounded_with", ()))
    return f"{_title(entry)} ({entry['confidence']:.2f}){rivals}"


def _over_workspace(diagnosis: Diagnosis) -> dict[str, float]:
    """Return the mean errors [mm] over the workspace of the data sheet and of the shipped model; empty if the fit has no covariance."""
    errors = errors_over_workspace(diagnosis)
    if errors is None:
        return {}
    data_sheet, shipped = (errors.all_sizes[model].banded(mean_over_poses) for model in (NOMINAL, SHIPPED))
    return {
        "data_sheet_error_mm": data_sheet.value / MM,
        "after_error_mm": shipped.value / MM,
        "after_error_at_most_mm": shipped.high / MM,
    }


def row_of_refusal(error: ScalarError) -> dict[str, Any]:
    """Return the line of data that were refused, without its folder: the status, and the first fault with the number of the others."""
    said = str(error).splitlines() or [type(error).__name__]
    more = f" (and {len(said) - 1} more)" if len(said) > 1 else ""
    return {"status": error.exit_status, "message": printable(said[0]) + more}


def cells(row: Mapping[str, Any]) -> list[str]:
    """Return the cells of a line in the order of ``COLUMNS``: numbers to six digits, and empty cells for what the line does not have."""
    return [_cell(row.get(column)) for column in COLUMNS]


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else printable(str(value))
