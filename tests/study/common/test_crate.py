"""A run as an RO-Crate: the metadata describe exactly the files in the archive, and another reader understands them."""

import hashlib
import json
import zipfile
from pathlib import Path

import pytest
from rocrate.rocrate import ROCrate
from study.common.crate import write_crate

ROOT = Path(__file__).resolve().parents[3]
PROFILE = "https://w3id.org/workflowhub/workflow-ro-crate/1.0"
CONFIG = {"results": "results", "first_seed": 1}


@pytest.fixture
def crate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, list[Path]]:
    """Return an archive, and the results in it."""
    monkeypatch.chdir(tmp_path)
    results = [Path("results/headline/errors.csv"), Path("results/paper.pdf")]
    for number, path in enumerate(results):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(bytes([number]) * 9)
    write_crate(Path("crate.zip"), root=ROOT, results=results, config=CONFIG)
    return tmp_path / "crate.zip", results


def graph_of(archive: zipfile.ZipFile) -> dict[str, dict]:
    """Return the entities of an archive's metadata by their identifiers."""
    content = json.loads(archive.read("ro-crate-metadata.json"))
    assert content["@context"] == "https://w3id.org/ro/crate/1.1/context"
    return {entity["@id"]: entity for entity in content["@graph"]}


def test_every_file_it_names_is_in_the_archive(crate):
    """The metadata name every file in the archive and no other, except the metadata themselves."""
    path, _ = crate
    with zipfile.ZipFile(path) as archive:
        names, graph = set(archive.namelist()), graph_of(archive)
    files = {
        name
        for name, entity in graph.items()
        if "File" in entity["@type"] and name != "ro-crate-metadata.json"
    }
    assert files == names - {"ro-crate-metadata.json"}
    assert {part["@id"] for part in graph["./"]["hasPart"]} == files
    assert "workflow/Snakefile" in files and "workflow/rules/simulate.smk" in files


def test_no_reference_leads_nowhere(crate):
    """Each identifier that an entity refers to is an entity of the graph, or an address."""
    path, _ = crate
    with zipfile.ZipFile(path) as archive:
        graph = graph_of(archive)
    for entity in graph.values():
        for value in entity.values():
            for reference in value if isinstance(value, list) else [value]:
                if isinstance(reference, dict):
                    target = reference["@id"]
                    assert target in graph or target.startswith("https://"), target
    assert all(graph["./"][key] for key in ("name", "description", "datePublished", "license"))


def test_the_metadata_describe_the_run(crate):
    """The metadata state that the workflow took the config and made the results, which are in the archive as they were on disk."""
    path, results = crate
    read = ROCrate(str(path))
    assert read.mainEntity.id == "workflow/Snakefile"
    assert "ComputationalWorkflow" in read.mainEntity.type
    assert PROFILE in read.metadata["conformsTo"]
    (action,) = (entity for entity in read.contextual_entities if "CreateAction" in entity.type)
    assert action["instrument"].id == "workflow/Snakefile"
    assert {result.id for result in action["result"]} == {path.as_posix() for path in results}
    with zipfile.ZipFile(path) as archive:
        assert json.loads(archive.read("config.json")) == CONFIG
        for result in results:
            packed = hashlib.sha256(archive.read(result.as_posix())).digest()
            assert packed == hashlib.sha256(result.read_bytes()).digest()


def test_a_result_that_is_absent_leaves_no_archive(tmp_path: Path):
    """If a result is absent, no archive is written."""
    with pytest.raises(FileNotFoundError):
        write_crate(tmp_path / "crate.zip", root=ROOT, results=[tmp_path / "none.csv"], config=CONFIG)
    assert list(tmp_path.iterdir()) == []
