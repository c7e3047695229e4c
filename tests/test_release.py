"""A release: one version in all places, or nothing changed."""

import importlib.util
import re
from datetime import date
from pathlib import Path

import pytest
from ruamel.yaml import YAML

ROOT = Path(__file__).resolve().parents[1]
DAY = date(2027, 3, 1)
FILES = ("scalar/__init__.py", "CITATION.cff", "CHANGELOG.md")


def load():
    """Return the module that `make release` runs."""
    spec = importlib.util.spec_from_file_location("release", ROOT / ".ci/release.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Return a folder with the files that hold the version, an open section in the changelog."""
    for name in FILES:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text((ROOT / name).read_text(encoding="utf-8"), encoding="utf-8")
    changelog = tmp_path / "CHANGELOG.md"
    text = changelog.read_text(encoding="utf-8")
    changelog.write_text(text.replace("## [Unreleased]\n", "## [Unreleased]\n\n- A change.\n", 1), "utf-8")
    return tmp_path


def headings(folder: Path) -> list[str]:
    """Return the headings of the changelog."""
    return re.findall(r"(?m)^## \[(.+?)\]", (folder / "CHANGELOG.md").read_text(encoding="utf-8"))


def test_one_version_everywhere(checkout: Path):
    """Package, citation and changelog say the same version and day; what was listed as changed is listed under it."""
    before = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    load().release(checkout, "99.1.0", DAY)
    assert '__version__ = "99.1.0"' in (checkout / "scalar/__init__.py").read_text(encoding="utf-8")
    citation = YAML(typ="safe").load((checkout / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == "99.1.0" and str(citation["date-released"]) == "2027-03-01"
    after = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    assert headings(checkout)[:2] == ["Unreleased", "99.1.0"]
    added = "\n## [99.1.0] - 2027-03-01\n"
    assert added in after and after.replace(added, "", 1).split() == before.split()


@pytest.mark.parametrize("version", ["", "1.0", "v9.9.9", "0.0.1"])
def test_a_wrong_version_changes_nothing(checkout: Path, version: str):
    """A text that is no version, and a version that is not later than the present one, are refused, and nothing changes."""
    before = [(checkout / name).read_bytes() for name in FILES]
    with pytest.raises(ValueError, match=r"version|later"):
        load().release(checkout, version, DAY)
    assert [(checkout / name).read_bytes() for name in FILES] == before


def test_a_release_without_a_change_is_refused(checkout: Path):
    """A second release in a row is refused, because it has nothing to list."""
    load().release(checkout, "99.1.0", DAY)
    with pytest.raises(ValueError, match="Unreleased"):
        load().release(checkout, "99.2.0", DAY)
