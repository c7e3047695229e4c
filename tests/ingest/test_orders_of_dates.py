"""Day and month of a date with slashes: the file settles their order, or the mapping states it; nothing is guessed."""

from datetime import datetime, timedelta

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.ingest.written_times import DAY_FIRST, MONTH_FIRST, Clock, Unsettled, read_times
from tests.ingest.foreign_tables import cells, header, imported, refused, run, tracker_mapping, write_table

WRITTEN = {DAY_FIRST: "%d/%m/%Y %H:%M:%S", MONTH_FIRST: "%m/%d/%Y %I:%M:%S %p"}


@given(
    st.datetimes(datetime(2001, 1, 1), datetime(2099, 1, 1)).map(lambda t: t.replace(microsecond=0)),
    st.lists(st.integers(0, 40 * 86_400), min_size=1, max_size=8),
    st.sampled_from([DAY_FIRST, MONTH_FIRST]),
)
def test_dates_are_read_as_they_were_written_or_not_at_all(start, steps, order):
    """Times that never decrease give their own seconds in either order, or are refused as open; with the order stated, they are always read."""
    moments = [start]
    for step in steps:
        moments.append(moments[-1] + timedelta(seconds=step))
    texts = [f"{moment:{WRITTEN[order]}}" for moment in moments]
    midnight = start.replace(hour=0, minute=0, second=0)
    seconds = [(moment - midnight).total_seconds() for moment in moments]
    stated = read_times(texts, order)
    assert isinstance(stated, Clock) and stated.seconds.tolist() == seconds
    found = read_times(texts)
    if isinstance(found, Unsettled):
        assert all(moment.day <= 12 for moment in moments)
    else:
        assert isinstance(found, Clock) and found.seconds.tolist() == seconds
        assert found.midnight == stated.midnight


def with_times(folder, texts):
    """Write a table with these times, and return its mapping and its file."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["time"] = {"column": "Clock"}
    rows = [[*row, text] for row, text in zip(cells(), texts, strict=True)]
    return mapping, write_table(folder / "a.csv", rows, [*header(), "Clock"])


@pytest.mark.parametrize(("dates", "days"), [(None, None), (DAY_FIRST, 1), (MONTH_FIRST, 31)])
def test_an_open_order_is_stated_in_the_mapping(tmp_path, dates, days):
    """From 3/4 to 4/4 is a day or, months first, the whole of a March; the import asks, and the answer decides."""
    texts = ["03/04/2026 9:00:00"] * 8 + ["04/04/2026 9:00:00"]
    mapping, file = with_times(tmp_path, texts)
    if dates is None:
        result = run(tmp_path, mapping, file)
        refused(tmp_path, result, "a.csv, row 2, column Clock", f"dates: {DAY_FIRST} or dates: {MONTH_FIRST}")
        assert len(result.output.splitlines()) == 1
        return
    mapping["text"]["dates"] = dates
    imported(tmp_path, mapping, file)
    time = pd.read_csv(tmp_path / "out/poses.csv")["time"].tolist()
    assert time[-1] - time[0] == days * 86_400.0


def test_times_that_increase_in_one_order_alone_settle_it(tmp_path):
    """From 31 January to 1 February no number need be above 12: 5/1, 6/1, 1/2 increase with days first alone."""
    texts = ["05/01/2026 9:00"] * 4 + ["06/01/2026 9:00"] * 4 + ["01/02/2026 9:00"]
    mapping, file = with_times(tmp_path, texts)
    imported(tmp_path, mapping, file)
    time = pd.read_csv(tmp_path / "out/poses.csv")["time"].tolist()
    assert time[-1] - time[0] == (datetime(2026, 2, 1) - datetime(2026, 1, 5)).days * 86_400.0


def test_dates_that_contradict_each_other_or_the_mapping_are_refused(tmp_path):
    """One date has no 26th month, another has it; and a stated order has to hold for every row."""
    mapping, file = with_times(tmp_path, ["26/11/2026 9:00"] * 4 + ["11/27/2026 9:00"] * 5)
    refused(tmp_path, run(tmp_path, mapping, file), "row 6", "write all dates alike")
    mapping["text"]["dates"] = MONTH_FIRST
    refused(tmp_path, run(tmp_path, mapping, file), "row 2", "no date in the order month/day/year")
    mapping, file = with_times(tmp_path, ["24/13/2026 9:00"] * 9)
    refused(tmp_path, run(tmp_path, mapping, file), "row 2", "no date ('24/13/2026 9:00')")
    mapping["text"]["dates"] = "d/m/y"
    refused(tmp_path, run(tmp_path, mapping, file), "text.dates", "day/month/year, month/day/year")
