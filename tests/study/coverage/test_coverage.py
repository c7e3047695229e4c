"""The study of coverage: the true arm is exact in what the calibration fixes, regions are what they are called, and ellipsoids are counted."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from study.coverage.design import COMBINATIONS, SCANNER, TRACKER, Design, load_coverage
from study.coverage.run import COLUMNS, Measured, run_workcell
from study.coverage.summaries import ALL, coverage, summarise_coverage
from study.spoiled_setups.workcell import OutOfReach

from scalar.errors import InvalidInput

CONFIG = "configs/coverage.yaml"


@pytest.fixture(scope="module")
def design(request):
    """Return the committed design."""
    return load_coverage(request.config.rootpath / CONFIG)


def measured(design, sensor, number=0, **changes):
    """Return a simulated workcell with many poses, and the random numbers that come next."""
    for attempt in range(50):
        case, rng = design.drawn(number, attempt)
        case = replace(
            case, sensor=sensor, poses=60, share=design.content["measured_share"][sensor], **changes
        )
        try:
            return Measured(case, rng), rng
        except OutOfReach:
            continue
    raise AssertionError("no arm reaches the planes")


@pytest.mark.parametrize("sensor", [SCANNER, TRACKER])
def test_the_true_arm_has_the_nominal_values_of_what_is_fixed_and_errs_elsewhere(design, sensor):
    """Predictions in the base frame then differ from the truth by chance alone, and with next to no noise hardly at all."""
    cell, rng = measured(design, sensor, noise_m=1e-9)
    calibration = cell.calibrated()
    errors = cell.errors[:4]
    free = [
        [f"{kind}_{j + 1}" in calibration.free for j in range(errors.shape[1])]
        for kind in ("a", "alpha", "d", "theta")
    ]
    np.testing.assert_array_equal(errors != 0, free)
    assert cell.counted(calibration, "outside", rng)["error_rms_mm"] < 1e-3


def test_regions_are_within_and_beyond_the_measured_ranges(design):
    """Inside, no joint leaves the range in which it was measured; outside, at least one does in every pose."""
    cell, rng = measured(design, TRACKER)
    low, high = cell.q.min(axis=0), cell.q.max(axis=0)
    for region, beyond in (("inside", False), ("outside", True)):
        q = cell.angles(region, rng)
        assert len(q) == design.content["predicted"]
        assert (np.any((q < low) | (q > high), axis=1) == beyond).all()


def test_ellipsoids_of_another_size_hold_all_poses_or_none(design):
    """If standard errors were stated a thousand times too large, every ellipsoid would hold the truth; a thousand times too small, none."""
    cell, rng = measured(design, TRACKER)
    calibration = cell.calibrated()
    for factor, share in ((1e6, 1.0), (1e-6, 0.0)):
        stated = replace(calibration, covariance=factor * calibration.covariance)
        found = cell.counted(stated, "inside", rng)
        assert found["held"] == share * found["predicted"]


def test_every_combination_has_its_turn_and_a_workcell_has_a_row_for_each_region(design):
    """Sensors, numbers of poses and origins of the prior are taken in turn; a longer design begins with the shorter one."""
    longer = Design({**design.content, "workcells": 1000})
    cases = [longer.drawn(number, 0)[0] for number in range(len(COMBINATIONS))]
    assert {(case.sensor, case.size, case.prior) for case in cases} == set(COMBINATIONS)
    assert cases == [design.drawn(number, 0)[0] for number in range(len(COMBINATIONS))]
    rows = run_workcell(design, len(COMBINATIONS) - 1)
    assert [row["region"] for row in rows] == ["inside", "outside"]
    assert all(set(row) <= set(COLUMNS) for row in rows)


def test_the_summary_counts_poses_and_takes_workcells_as_the_trials(design):
    """Two workcells that hold everything and two that hold nothing: the share is a half, and its interval spans all of 0 to 1, or nearly."""
    rows = pd.DataFrame(
        {"number": number, "sensor": TRACKER, "size": "few", "prior": "stated", "region": region, "status": status,
         "predicted": 20.0, "held": 20.0 * (number % 2), "error_rms_mm": 0.1, "std_rms_mm": 0.1}
        for number, status in [*((k, "calibrated") for k in range(4)), (4, "Undetermined")]
        for region in ("inside", "outside")
    )  # fmt: skip
    rows.loc[rows["status"] != "calibrated", ["predicted", "held"]] = np.nan
    table = coverage(rows).set_index(["sensor", "region"])
    whole = table.loc[(ALL, ALL)]
    assert (whole["workcells"], whole["failed"], whole["predicted"], whole["held"]) == (5, 1, 160, 80)
    assert whole["share"] == 0.5 and whole["low"] < 0.1 and whole["high"] > 0.9
    numbers, _ = summarise_coverage(rows, design.content)
    assert numbers["coverage"]["outside"]["share"] == 0.5 and numbers["workcells_below_half"] == 2


def test_a_design_with_a_wrong_key_is_refused(tmp_path, request):
    """The fault names the file and the key."""
    text = (request.config.rootpath / CONFIG).read_text(encoding="utf-8")
    (tmp_path / "wrong.yaml").write_text(text.replace("predicted: 20", "predicted: 0"), encoding="utf-8")
    with pytest.raises(InvalidInput, match=r"wrong\.yaml.*predicted"):
        load_coverage(tmp_path / "wrong.yaml")
