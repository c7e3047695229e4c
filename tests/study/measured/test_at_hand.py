"""The measured sets whose files are at hand are studied, and one warning names the missing files and what to do."""

import pytest
from study.measured.at_hand import SetsAtHand
from study.measured.originals import Original

NOWHERE = "http://127.0.0.1:9/{path}"


@pytest.fixture
def at_hand(tmp_path):
    """Return how to look for the sets `one` and `two`, of a file each, and the list that warnings go to."""
    said: list[str] = []

    def look(folder: str = "", address: str = NOWHERE) -> SetsAtHand:
        originals = {
            name: [Original(name, name, f"{name}.csv", "", "someone/data", "abc", f"{name}.csv")]
            for name in ("one", "two")
        }
        return SetsAtHand(originals, folder, [address], tmp_path / "kept", {"two": "one"}, said.append)

    return look, said


def test_without_files_and_network_nothing_is_at_hand_and_it_is_said_once(at_hand):
    """If several rules ask for the sets, one warning names the files, the sets and what to do."""
    look, said = at_hand
    sets = look()
    assert sets.names == sets.names == []
    assert sets.transferred == {}
    (warning,) = said
    for words in ("one.csv", "two.csv", "measured={folder: PATH}", "Left out until then: one, two"):
        assert words in warning


def test_files_are_looked_for_only_when_a_workflow_needs_them(at_hand):
    """A workflow that does not study measured robots neither waits for the network nor prints a warning."""
    look, said = at_hand
    look()
    assert said == []


def test_a_set_is_at_hand_by_its_folder_or_because_it_was_fetched_before(at_hand, tmp_path):
    """A set is at hand if its files are in the folder or were fetched before, and a transfer needs both of its sets."""
    look, said = at_hand
    (tmp_path / "local").mkdir()
    (tmp_path / "local/two.csv").write_text("1")
    alone = look(str(tmp_path / "local"))
    assert alone.names == ["two"]
    assert alone.transferred == {}
    assert "one.csv" in said[0] and "two.csv" not in said[0]
    (tmp_path / "kept/one").mkdir(parents=True)
    both = look(str(tmp_path / "local"))
    assert both.names == ["one", "two"]
    assert both.transferred == {"two": "one"}
    assert len(said) == 1


def test_all_sets_are_at_hand_where_an_address_answers(at_hand, tmp_path):
    """If an address answers, all sets are at hand; their files are fetched when their jobs run."""
    look, said = at_hand
    (tmp_path / "one.csv").write_text("1")
    assert look(address=tmp_path.as_uri() + "/{path}").names == ["one", "two"]
    assert said == []
