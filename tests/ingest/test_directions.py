"""Directions of approach that a file states in words or signs become 1 and -1, as the mapping says."""

import pytest

from tests.ingest.foreign_tables import N, cells, header, imported, refused, run, tracker_mapping, write_table


def with_directions(folder, texts, **keys):
    """Write a table in which joint 2 comes from the directions of these texts, one a row, and return its mapping and its file."""
    mapping = tracker_mapping()
    others = {f"approach{i}": {"column": "one"} for i in range(1, 7) if i != 2}
    mapping["poses"]["columns"] |= {**others, "approach2": {"column": "dir", **keys}}
    rows = [[*row, "1", text] for row, text in zip(cells(), texts, strict=True)]
    return mapping, write_table(folder / "a.csv", rows, [*header(), "one", "dir"])


def of(written, size=N):
    """Return texts for all rows, repeating those that are given."""
    return [written[k % len(written)] for k in range(size)]


@pytest.mark.parametrize(
    ("one", "two", "keys", "directions"),
    [
        ("+", "-", {}, (1, -1)),
        ("+", "+", {}, (1, 1)),
        ("-", "-", {}, (-1, -1)),
        ("1", "-1", {}, (1, -1)),
        ("up", "down", {"values": {"up": 1, "down": -1}}, (1, -1)),
        ("cw", "ccw", {"values": {"cw": -1, "ccw": 1}}, (-1, 1)),
        ("1", "2", {"values": {"1": 1, "2": -1}}, (1, -1)),
        ("pos", "-", {"values": {"pos": 1}}, (1, -1)),
        ("up", "down", {"values": {"up": 1, "down": -1}, "sign": -1}, (-1, 1)),
        ("on", "off", {"values": {"on": 1, "off": -1}}, (1, -1)),
    ],
)
def test_words_and_signs_become_directions(tmp_path, one, two, keys, directions):
    """Rows have the direction that the mapping states for their text; ``sign`` turns it."""
    mapping, file = with_directions(tmp_path, of([one, two, one]), **keys)
    found = imported(tmp_path, mapping, file).poses["approach2"].tolist()
    assert found == of([directions[0], directions[1], directions[0]])


def test_a_joint_that_stands_still_keeps_its_direction(tmp_path):
    """0 repeats the direction of the row above; before the first move there is none, and the first row is named."""
    values = {"values": {"up": 1, "down": -1, "still": 0}}
    mapping, file = with_directions(tmp_path, of(["down", "still", "still", "up", "still"]), **values)
    found = imported(tmp_path, mapping, file).poses["approach2"].tolist()
    assert found == of([-1, -1, -1, 1, 1])
    other = tmp_path / "other"
    other.mkdir()
    mapping, file = with_directions(other, of(["still", "up", "still"]), **values)
    result = run(other, mapping, file)
    refused(other, result, "a.csv, row 2, column dir", "neither -1 nor 1")
    assert len(result.output.splitlines()) == 1


def test_words_without_values_are_refused_with_the_key_to_write(tmp_path):
    """One line names the words and the key; with ``values`` that lack one, one line names this one."""
    mapping, file = with_directions(tmp_path, of(["hoch", "runter"]))
    result = run(tmp_path, mapping, file)
    refused(tmp_path, result, "column dir", "values: {'hoch': 1, 'runter': -1}", "poses.columns.approach2")
    assert len(result.output.splitlines()) == 1
    mapping["poses"]["columns"]["approach2"]["values"] = {"hoch": 1}
    result = run(tmp_path, mapping, file)
    refused(tmp_path, result, "row 3", "runter", "add it to poses.columns.approach2.values")
    assert len(result.output.splitlines()) == 1


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("q1", {"up": 1}, "only directions of approach have values"),
        ("approach2", {"up": 2}, "poses.columns.approach2.values.up"),
        ("approach2", {}, "poses.columns.approach2.values"),
    ],
)
def test_wrong_values_are_refused_by_their_key(tmp_path, name, values, words):
    """Values belong to directions, and are 1, -1 or 0."""
    mapping, file = with_directions(tmp_path, of(["+", "-"]))
    mapping["poses"]["columns"][name]["values"] = values
    refused(tmp_path, run(tmp_path, mapping, file), words)
