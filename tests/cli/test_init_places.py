"""Places at which `scalar init` and `scalar import` cannot read or write."""

from tests.cli.test_init import refused, run
from tests.ingest.foreign_tables import refused as import_refused
from tests.ingest.foreign_tables import run as run_import
from tests.ingest.foreign_tables import tracker_mapping


def test_a_circle_of_links_is_no_folder(tmp_path):
    """A link that leads to itself is refused as a place for a dataset; it was once a fault of the program."""
    (tmp_path / "circle").symlink_to("circle")
    for folder in (tmp_path / "circle", tmp_path / "circle" / "cell"):
        refused(run("init", folder, "--robot", "ur10e", "--sensor", "tracker"), "cannot be written")


def test_a_circle_of_links_is_no_table(tmp_path):
    """A table that leads to itself is refused by its name; it was once a fault of the program."""
    (tmp_path / "table.csv").symlink_to("table.csv")
    result = run_import(tmp_path, tracker_mapping(), tmp_path / "table.csv")
    import_refused(tmp_path, result, "table.csv", "cannot be read")
