"""A sweep varies one key of the scene, which every case states."""

import pytest
from study.common.grid import Case
from study.sweeps.cases import in_groups, most_poses, refuse_cases_off_the_axis, values_on_axis

from scalar.errors import InvalidInput

AXIS = {"key": "noise.range_noise_std_m", "grid": "grids/noise.csv", "factor": 1000}
LOW, HIGH = (Case(name, None, {AXIS["key"]: std}) for name, std in (("low", 1e-4), ("high", 2e-3)))


def test_values_are_in_the_unit_of_the_label():
    """The factor converts what the scene states in metres; without one it is the scene's own number."""
    cases = {"low": LOW, "high": HIGH}
    assert values_on_axis(AXIS, cases) == {"low": pytest.approx(0.1), "high": pytest.approx(2.0)}
    assert values_on_axis({"key": AXIS["key"]}, cases) == {"low": 1e-4, "high": 2e-3}


def test_every_case_off_the_axis_is_named():
    """A case that leaves the key as it is, and one that starts from another scene, are refused by name."""
    refuse_cases_off_the_axis({"noise": AXIS}, {"noise": {"low": LOW, "high": HIGH}})
    silent, elsewhere = Case("silent", None, {}), Case("elsewhere", "other.yaml", LOW.overrides)
    with pytest.raises(InvalidInput) as refused:
        refuse_cases_off_the_axis(
            {"noise": AXIS}, {"noise": {"low": LOW, "silent": silent, "elsewhere": elsewhere}}
        )
    assert [fault.file for fault in refused.value.faults] == ["grids/noise.csv"] * 2
    for name, fault in zip(("silent", "elsewhere"), refused.value.faults, strict=True):
        assert name in str(fault) and AXIS["key"] in str(fault)


def test_groups_hold_every_case_once_and_another_row_changes_no_full_group():
    """A job's name says which rows of the grid it runs, so a row at the end changes no job that is full."""
    cases = {f"case-{k}": LOW for k in range(7)}
    groups = in_groups(cases, 3)
    assert [name for group in groups.values() for name in group] == list(cases)
    more = in_groups({**cases, "one-more": HIGH}, 3)
    assert {name: more[name] for name in list(groups)[:2]} == dict(list(groups.items())[:2])
    assert in_groups({}, 3) == {}


def test_a_posture_plan_holds_the_largest_case():
    """The plan holds the largest case of all sweeps, since they share it; a workflow without sweeps has no plan."""
    poses = {name: Case(name, None, {"poses_per_plane": int(name)}) for name in ("12", "40")}
    assert most_poses({"noise": {"low": LOW}, "poses": poses}) == 40
    assert most_poses({}) == 1
