"""The rules that limit the confidence in a name where an explanation that neither the trials nor the scores contain explains as much."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.dataset import Dataset
from scalar.diagnosis.explained import Explained
from scalar.diagnosis.held_out.outer_split import OuterSplit
from scalar.diagnosis.naming.base_and_joints import limited_by_joint_compliance
from scalar.diagnosis.naming.errors_of_assembly import limited_by_assembly
from scalar.diagnosis.naming.few_positions import limited_by_few_positions
from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.naming.many_orders import limited_by_many_orders
from scalar.diagnosis.naming.not_distinguished import limited_by_listed_rivals
from scalar.diagnosis.naming.one_joint_moves import limited_by_one_joint
from scalar.diagnosis.naming.one_path import limited_by_path
from scalar.diagnosis.naming.orders_between import limited_by_orders_between
from scalar.diagnosis.naming.rounded_record import limited_by_rounding
from scalar.diagnosis.naming.same_joint import limited_by_same_joint
from scalar.diagnosis.naming.several_orders import limited_by_several_orders
from scalar.diagnosis.naming.step_at_boundary import limited_by_boundaries
from scalar.diagnosis.naming.stretched_measurements import limited_by_stretched_axis
from scalar.diagnosis.naming.two_halves import limited_by_halves
from scalar.diagnosis.naming.typical_masses import limited_by_typical_masses
from scalar.diagnosis.naming.unstated_order import limited_by_order
from scalar.diagnosis.naming.usual_odds import limited_by_usual_odds
from scalar.diagnosis.naming.warmth_named_twice import limited_by_same_warmth
from scalar.diagnosis.naming.weight_and_structure import limited_by_structure


def limited_names(
    found: Sequence[Finding], run: Explained, halves: OuterSplit | None, given: Dataset
) -> tuple[Finding, ...]:
    """Return the findings, each with the confidence that all rules allow.

    Args:
        found: All findings.
        run: The run that found them.
        halves: The answers of the two halves of the poses, or None.
        given: The dataset as read.
    """
    settings, dataset = run.after.settings, run.cleaned.dataset
    least, n_poses = settings.naming.least_confidence, dataset.n_poses
    found = limited_by_halves(found, halves, least)
    found = limited_by_rounding(found, run.before, least)
    found = limited_by_stretched_axis(found, run.before, least)
    found = limited_by_many_orders(found, n_poses, settings.spectrum.many_orders, least)
    found = limited_by_orders_between(found, run.after, least)
    found = limited_by_order(found, given, least)
    found = limited_by_path(found, dataset, least)
    found = limited_by_typical_masses(found, run.after, least)
    found = limited_by_joint_compliance(found, n_poses, least)
    found = limited_by_one_joint(found, dataset.q, least)
    found = limited_by_few_positions(found, run.after, run.candidates, least)
    found = limited_by_assembly(found, least)
    found = limited_by_boundaries(found, dataset, settings.selection.change_margin, least)
    found = limited_by_same_warmth(found, least)
    found = limited_by_same_joint(found, least)
    found = limited_by_listed_rivals(found)
    found = limited_by_usual_odds(found, least)
    found = limited_by_several_orders(found, least)
    return limited_by_structure(found, n_poses, least)
