"""Reading a table leaves nothing of Python in the hands of a thread that may outlive the call."""

import sys

from scalar.data.io.csv_reader import _parse_fast
from scalar.data.located_table import Layout


def test_no_thread_holds_the_bytes_of_a_table_that_was_read() -> None:
    """After each of many readings, the bytes have as many references as before: a thread that releases them later would abort a process that ends."""
    raw = b"a,b,c\n" + b"1.5,2.5,3.5\n" * 90
    layout = Layout(required=("a", "b", "c"))
    before = sys.getrefcount(raw)
    for _ in range(1000):
        assert _parse_fast(raw, ["a", "b", "c"], layout) is not None
        assert sys.getrefcount(raw) == before
