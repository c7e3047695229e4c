"""Original files are accepted from any place, but only if they are the published ones."""

import hashlib
import shutil
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from study.measured.originals import Original, answers, checksums, get_originals, read_originals

from scalar.errors import InvalidInput

ROOT = Path(__file__).parents[3]
CONTENT = b"q1;q2\r\n0,1;0,2\r\n"
ORIGINAL = Original(
    "a_set",
    "a_mapping",
    "data.csv",
    hashlib.sha256(CONTENT).hexdigest(),
    "someone/some-data",
    "abc123",
    "Series/data.csv",
)


def published(folder: Path, content: bytes = CONTENT) -> str:
    """Put a file where the address that is returned has it."""
    path = folder / "some-data/abc123/Series/data.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return folder.as_uri() + "/some-data/{commit}/{path}"


def test_the_second_address_serves_where_the_first_fails_or_is_wrong(tmp_path):
    """A file with the wrong checksum is not accepted, and the next address is tried."""
    wrong = published(tmp_path / "wrong", b"moved")
    right = published(tmp_path / "right")
    nothing = (tmp_path / "none").as_uri() + "/{path}"
    get_originals([ORIGINAL], "", [nothing, wrong, right], tmp_path / "out")
    (tmp_path / "out/.snakemake_timestamp").touch()
    assert checksums(tmp_path / "out") == {"data.csv": ORIGINAL.sha256}
    assert answers(ORIGINAL.addresses([right])[0])
    assert not answers(ORIGINAL.addresses([nothing])[0])


@pytest.mark.parametrize(
    "place", ["data.csv", "some-data/data.csv", "some-data/Series/data.csv", "Series/data.csv"]
)
def test_a_local_folder_may_be_flat_by_repository_or_a_clone(tmp_path, place):
    """A file in a local folder is found in all three arrangements, and no address is asked for it."""
    path = tmp_path / "local" / place
    path.parent.mkdir(parents=True)
    path.write_bytes(CONTENT)
    get_originals([ORIGINAL], str(tmp_path / "local"), [], tmp_path / "out")
    assert (tmp_path / "out/data.csv").read_bytes() == CONTENT


def test_another_file_of_that_name_is_refused_and_nothing_is_left(tmp_path):
    """Whether the file is local or fetched, the message names it, the checksum found and what to do, and no file is left behind."""
    (tmp_path / "local").mkdir()
    (tmp_path / "local/data.csv").write_bytes(b"edited")
    with pytest.raises(InvalidInput, match="not the file that was published"):
        get_originals([ORIGINAL], str(tmp_path / "local"), [], tmp_path / "out")
    with pytest.raises(InvalidInput, match=r"data.csv: cannot be fetched .* measured.folder"):
        get_originals(
            [ORIGINAL], "", [published(tmp_path, b"edited"), "http://127.0.0.1:9/{path}"], tmp_path / "out"
        )
    shutil.rmtree(tmp_path / "local")
    assert [path.name for path in tmp_path.iterdir()] == ["some-data"]


def test_every_listed_set_has_a_mapping_that_names_its_files():
    """The mapping of each set names exactly the files that are fetched, each of which has a checksum."""
    from scalar.ingest.mapping_reader import load_mapping

    everything = {
        **read_originals(ROOT / "workflow/resources/measured.csv"),
        **read_originals(ROOT / "workflow/resources/measured_by_hand.csv"),
    }
    for originals in everything.values():
        assert len({original.mapping for original in originals}) == 1
        mapping = load_mapping(ROOT / f"configs/measured/{originals[0].mapping}.yaml")
        patterns = [rule.name for block in (mapping.poses, mapping.points) if block for rule in block.files]
        matches = [[p for p in patterns if fnmatchcase(original.file, p)] for original in originals]
        assert all(len(found) == 1 for found in matches)
        assert {found[0] for found in matches} == set(patterns)
        assert all(len(original.sha256) == 64 for original in originals)
