"""Measured sets: the checks of the diagnosis, and the agreement of two campaigns on a gear."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from study.measured.gears import agreement, gear_errors
from study.measured.models import BEFORE, compare, on_a_fresh_split, on_shuffled_angles
from study.measured.repeated import floor_of
from study.paper.measured import measured_counts
from study.plots.measured import draw_errors, draw_gears

from scalar import diagnose
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.calibrate import calibrate
from scalar.units import MM
from tests.diagnosis.bumpy_joints import TRACKER_NOISE, bumps, bumpy
from tests.random_scene import make_scene

ORDERS = tuple(range(1, 33))
ERRING = 3


ROOT = Path(__file__).parents[3]


def campaign(seed, landscape=5):
    """Return a set of a tracked arm of which joint 3 errs, and its calibration with all orders of that joint."""
    dataset = bumpy(seed, poses_per_plane=150, erring=(ERRING,), landscape=landscape)
    belief = JointHarmonic(ERRING, ORDERS, term_std=(1e-4,) * len(ORDERS))
    return dataset, calibrate(dataset, effects=[belief])


@pytest.fixture(scope="module")
def one():
    """Return one campaign: a set of a tracked arm and its calibration."""
    return campaign(1)


def test_another_split_confirms_a_true_effect(one):
    """With the true effect, poses of another split are predicted nearly to the tracker's noise, and without it they are not."""
    found = on_a_fresh_split(*one)
    assert 0.2 * one[0].n_poses < found["poses"] < 0.4 * one[0].n_poses
    assert found["after_rms_mm"] < 2 * np.sqrt(3) * TRACKER_NOISE / MM < 0.5 * found["before_rms_mm"]


def test_an_effect_at_shuffled_angles_gains_nothing(one):
    """As a control, the same columns at shuffled angles predict held-out poses no better than the geometry alone."""
    geometry = on_a_fresh_split(*one)["before_rms_mm"]
    assert on_shuffled_angles(*one)["held_out_rms_mm"] > 0.95 * geometry


@pytest.mark.parametrize("seed", [1, 3, 4])
def test_the_geometry_of_the_table_is_the_one_that_a_diagnosis_has_without_effects(seed):
    """On 11 poses, which leave geometry to the data sheet, both have the same held-out error; without its priors it was 0.2 to 13 times as large."""
    dataset = make_scene(kind="tracker", seed=seed, poses_per_plane=5, noise=1e-4).dataset
    dataset = dataset.subset(np.arange(dataset.n_poses) < 11)
    before = diagnose(dataset).to_mapping()["residual"]["before"]["held_out_rms_mm"]
    assert compare(dataset)[BEFORE]["held_out_rms_mm"] == pytest.approx(before, rel=1e-2)


def test_the_error_of_a_gear_is_the_one_injected(one):
    """Over the measured angles the curve is the injected one up to a straight line, within its standard error."""
    dataset, found = one
    table = gear_errors(found, dataset)
    assert set(table["joint"]) == {ERRING}
    seen = table[table["seen"]]
    x = np.deg2rad(seen["angle_deg"].to_numpy())
    injected = bumps(500 + ERRING)(x) * 1e3
    rest = seen["error_mrad"].to_numpy() - injected
    rest -= np.polyval(np.polyfit(x, rest, 1), x)
    assert np.std(rest) < 0.25 * np.std(injected)
    q = dataset.q[:, ERRING - 1]
    inside = (x > q.min() - 0.1) & (x < q.max() + 0.1)
    assert inside.all() and len(seen) > 20


def test_campaigns_of_one_arm_agree_and_of_two_do_not(one):
    """The gear errors that two campaigns find on the same arm correlate; those of another arm do not."""
    again, other = campaign(2), campaign(3, landscape=9)
    mine = gear_errors(one[1], one[0])
    (same,) = agreement(mine, gear_errors(again[1], again[0]))
    (different,) = agreement(mine, gear_errors(other[1], other[0]))
    assert same["joint"] == ERRING and same["correlation"] > 0.9
    assert same["apart_rms_mrad"] < 0.5 * same["one_rms_mrad"]
    assert abs(different["correlation"]) < 0.5


def test_no_gears_no_rows(one):
    """A calibration without harmonics gives no rows of gears, and none of agreement."""
    dataset, found = one
    bare = replace(found, model=replace(found.model, effects=()))
    table = gear_errors(bare, dataset)
    assert len(table) == 0 and agreement(table, gear_errors(found, dataset)) == []


def test_the_figures_show_every_set_and_joint(one):
    """There are bars for every set, and a panel for every joint of a campaign with several."""
    errors = pd.DataFrame(
        [
            {"set": name, "model": model, "held_out_rms_mm": 0.3}
            for name in ("ur10_tracker_c", "motoman_plane_contact")
            for model in ("base_and_tool", "geometry", "effects_of_ur10_tracker_c")
        ]
    )
    (ax,) = draw_errors(errors).axes
    assert len(ax.patches) == 6
    curve = gear_errors(one[1], one[0])
    gears = pd.concat([curve.assign(set="c", joint=2), curve.assign(set="c"), curve.assign(set="d", joint=5)])
    assert len(draw_gears(gears).axes) == 2


def test_the_floor_of_a_campaign_is_the_scatter_of_its_returns():
    """Logged angles that differ by hundredths of a milliradian are one pose; a campaign that never comes back has no floor."""
    arm = make_scene("vs060", "tracker", poses_per_plane=8, noise=1e-9, seed=4).dataset
    rng = np.random.default_rng(3)
    rows = np.tile(np.arange(8), 6)
    poses = arm.poses.iloc[rows].assign(pose=np.arange(48), order=np.arange(48.0))
    for i in range(1, 7):
        poses[f"q{i}"] += rng.uniform(-1e-5, 1e-5, 48)
    shift = 4e-5 * rng.standard_normal((48, 3))
    back = replace(
        arm, poses=poses.reset_index(drop=True), points=arm.points[rows] + shift, starts=np.arange(49)
    )
    found = floor_of(back)
    assert (found["returns"], found["poses"]) == (40, 8)
    assert found["scatter_mm"] == pytest.approx(np.sqrt(3) * 0.04, rel=0.2)  # 120 degrees of freedom: 6 %
    assert floor_of(arm) is None


def committed():
    """Return the sets of the committed summary that have errors on unseen poses, README, and the page on measured arms."""
    sets = json.loads((ROOT / "paper/summaries/measured/numbers.json").read_text(encoding="utf-8"))["sets"]
    judged = {name: found for name, found in sets.items() if found["unseen"]["before_rms_mm"] is not None}
    return judged, *(
        (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "docs/measured_arms.md")
    )


def test_readme_and_documentation_say_in_how_many_sets_a_correction_helps():
    """README and documentation give the numbers of sets that are corrected, of those left as they are, and of verdicts, as the summary has them."""
    sets, readme, page = committed()
    found = measured_counts(sets)
    assert found["sets"] == found["corrected"] + found["not_corrected"] and not found["harmful"]
    sentence = (
        f"In {number(found['corrected'])} of these {number(found['sets'])} campaigns the correction reduces the error on unseen poses; "
        f"in the other {number(found['not_corrected'])} nothing is corrected beyond the geometry"
    )
    verdicts = f"The verdict is `unattributed` in {number(found['unattributed'])} of them"
    for text in (readme, page):
        assert sentence in " ".join(text.split()) and verdicts in " ".join(text.split())


def test_the_tables_say_what_the_summaries_say():
    """In the documentation, every error in the table of measured arms is that of the committed summaries, to two places."""
    sets, _, page = committed()
    for name, found in sets.items():
        models, unseen = found["models"], found["unseen"]
        errors = [models["base_and_tool"]["held_out_rms_mm"]]
        told = [f"{errors[0]:.2f}"] + [
            f"{unseen[f'{when}_rms_mm']:.2f} ± {unseen[f'{when}_rms_spread_mm']:.2f}"
            for when in ("before", "after")
        ]
        told.append(f"{found['checks']['shuffled']['held_out_rms_mm']:.2f}")
        repeated = found["repeated_poses"]
        told.append(f"{repeated['scatter_mm']:.2f} ({repeated['returns']})" if repeated else "–")
        (row,) = [line for line in page.splitlines() if line.startswith(f"| `{name}`:")]
        assert f", {models['geometry']['poses']} poses" in row
        assert [cell.strip() for cell in row.split("|")[2:7]] == told
        assert all(len(checksum) == 64 for checksum in found["files_sha256"].values())


def of_one_set(before, after, verdict="effect", sure=0, held_out=(0.4, 0.2, 0.3), scatter=0.05):
    """Return the entry of a set, with errors on held-out poses of the geometry, of the correction and of the control."""
    geometry, corrected, control = held_out
    return {
        "verdict": verdict,
        "sure": sure,
        "models": {
            "geometry": {"held_out_rms_mm": geometry},
            "geometry_and_effects": {"held_out_rms_mm": corrected},
        },
        "checks": {"shuffled": {"held_out_rms_mm": control}},
        "unseen": {
            "before_rms_mm": before,
            "before_rms_spread_mm": scatter / 2,
            "after_rms_mm": after,
            "after_rms_spread_mm": scatter,
        },
    }


def test_counts_of_measured_sets():
    """A set whose error stays is not corrected, one whose error grows is harmed, and one without errors on unseen poses counts as neither."""
    sets = {
        "iiwa": of_one_set(0.4, 0.1, sure=1),
        "ma1440": of_one_set(0.4, 0.4, "unattributed", held_out=(0.4, 0.4, 0.3)),
        "ma2010": of_one_set(0.4, 0.5, "unattributed", sure=2),
        "irb": of_one_set(None, None),
        "irb_2": of_one_set(0.4, 0.3, scatter=0.2),
    }
    found = measured_counts(sets)
    assert {key: found[key] for key in ("sets", "unattributed", "named", "unseen", "corrected", "not_corrected", "harmful")} == {
        "sets": 5, "unattributed": 2, "named": 2, "unseen": 4, "corrected": 2, "not_corrected": 1, "harmful": 1
    }  # fmt: skip
    assert found["clearly_corrected"] == 1, (
        "an error that falls by less than its scatter over the parts is not clearly smaller"
    )
    assert (found["motoman"]["unseen"], found["motoman"]["harmful"]) == (2, 1)


def test_the_control_is_compared_with_geometry_and_correction():
    """The control is ahead only if it has the smallest of three errors, and its share of the gain is defined only where there is a gain."""
    sets = {
        "iiwa_a": of_one_set(0.4, 0.1, held_out=(1.0, 0.2, 0.4)),
        "iiwa_b": of_one_set(0.4, 0.1, held_out=(1.0, 0.5, 0.9)),
        "iiwa_c": of_one_set(0.4, 0.4, held_out=(1.0, 1.0, 0.9)),
    }
    found = measured_counts(sets)
    assert found["control_ahead"] == ["iiwa_c"]
    assert found["control_share"] == {"least": pytest.approx(0.2), "greatest": pytest.approx(0.75)}


def test_a_correction_that_errs_more_at_held_out_poses_is_listed():
    """A set is listed if held-out poses err more by over a twentieth with the correction; a smaller difference is not, and neither is a gain."""
    sets = {
        "worse": of_one_set(0.4, 0.3, held_out=(1.0, 1.06, 1.2)),
        "alike": of_one_set(0.4, 0.3, held_out=(1.0, 1.04, 1.2)),
        "better": of_one_set(0.4, 0.3, held_out=(1.0, 0.5, 1.2)),
    }
    assert measured_counts(sets)["held_out_worse"] == ["worse"]


def number(n):
    """Return a number up to twelve as a word."""
    words = "no one two three four five six seven eight nine ten eleven twelve".split()
    return words[n]
