"""The documentation: it builds without a warning, every link leads somewhere, and every effect has a page with its picture."""

import os
import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from lxml import html

from docs.site.catalogue import CATALOGUE, NOISES, ROOT, SCENE
from docs.site.effect_pages import write_noise_pages
from docs.site.noise_words import NOISE_WORDS
from scalar.data.io.plain_yaml import load_yaml
from scalar.diagnosis.naming.most_confidence import NOT_SURE
from scalar.effects.registry import BUILT_IN
from scalar.report.words import COMPONENTS
from scalar.simulation.config import complete_config

EXAMPLES = sorted(path.stem for path in (ROOT / "docs/examples").glob("*.py"))


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """Return the site, built with warnings as errors; the examples have run."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-d", str(folder / "trees")]
    ran = subprocess.run(
        [*command, str(ROOT / "docs"), str(folder / "html")],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
    )
    assert ran.returncode == 0, ran.stderr + ran.stdout
    return folder / "html"


def test_links_of_the_sources_lead_to_files_of_the_repository():
    """Every page to which README and documentation link is a file of the repository, for readers who do not build the site."""
    kept = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    files = {(ROOT / name).resolve() for name in kept}
    for source in [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]:
        for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", source.read_text(encoding="utf-8")):
            if not urlsplit(link).scheme:
                assert (source.parent / unquote(link)).resolve() in files, f"{source.name}: {link}"


def links(page: Path) -> set[str]:
    """Return what a page refers to: links, pictures, styles, scripts."""
    tree = html.parse(str(page))
    return {str(value) for value in tree.xpath("//@href | //@src")}


@pytest.mark.slow
def test_no_link_leads_nowhere(site: Path):
    """Each local file that a page refers to is there, with the place in it; nothing is loaded from the network."""
    places: dict[Path, set[str]] = {}
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > len(BUILT_IN) + 8
    for page in pages:
        for link in links(page):
            parts = urlsplit(link)
            if parts.scheme or not (parts.path or parts.fragment):
                assert parts.scheme in ("", "https", "data"), (page, link)
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            assert target.exists(), f"{page}: {link}"
            if parts.fragment and target.suffix == ".html":
                if target not in places:
                    places[target] = set(map(str, html.parse(str(target)).xpath("//@id")))
                assert unquote(parts.fragment) in places[target], f"{page}: {link}"
        tree = html.parse(str(page))
        loaded = tree.xpath("//script/@src | //img/@src | //link[@rel='stylesheet']/@href")
        assert not [link for link in loaded if urlsplit(str(link)).netloc], page


@pytest.mark.slow
@pytest.mark.parametrize("name", [*(kind.name for kind in BUILT_IN), *NOISES])
def test_each_effect_has_a_page(site: Path, name: str):
    """The page of an effect, or of one of the two random errors, shows its picture, says what to do about it, and how to inject it."""
    tree = html.parse(str(site / f"generated/effects/{name}.html"))
    assert any(f"{name}.png" in str(source) for source in tree.xpath("//img/@src"))
    headings = " ".join(str(text) for text in tree.xpath("//h2/text()"))
    assert "What to do about it" in headings and "How to inject it" in headings
    assert "None" not in "".join(map(str, tree.xpath("//article//p/text()")))


def test_the_page_of_a_jitter_says_what_limits_its_confidence(tmp_path):
    """Whoever reads the page of a jitter learns that only returns to the same poses make its name sure, and which causes look alike."""
    write_noise_pages(tmp_path)
    page = (tmp_path / "pose_jitter.md").read_text(encoding="utf-8")
    assert f"at most {NOT_SURE:g} unless the arm came back to some of the poses" in page
    assert "the pull of a hose or a loose mount scatters" in page


def test_the_catalogue_shows_the_random_errors():
    """Every random error of whole poses that a diagnosis can name has its words and a scene that the simulator accepts."""
    path = ROOT / SCENE
    assert set(NOISES) == set(NOISE_WORDS) == set(COMPONENTS)
    for shown in NOISES.values():
        complete_config({**load_yaml(path), **shown.changes}, base_dir=path.parent)


@pytest.mark.slow
def test_each_example_has_run(site: Path):
    """The page of an example shows what it printed and drew, and offers it as a notebook."""
    assert EXAMPLES
    for name in EXAMPLES:
        page = site / f"generated/examples/{name}.html"
        tree = html.parse(str(page))
        assert tree.xpath("//div[contains(@class, 'sphx-glr-script-out')]"), name
        assert any(f"sphx_glr_{name}" in str(source) for source in tree.xpath("//img/@src")), name
        assert any(link.endswith(f"{name}.ipynb") for link in links(page)), name


def test_the_catalogue_shows_what_the_registry_holds():
    """The catalogue has one entry for each effect of the registry, and the simulator accepts the scene of each."""
    assert list(CATALOGUE) == [kind.name for kind in BUILT_IN]
    path = ROOT / SCENE
    for shown in CATALOGUE.values():
        complete_config({**load_yaml(path), **shown.changes}, base_dir=path.parent)
