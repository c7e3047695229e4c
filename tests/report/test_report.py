"""The page of a report opens offline, shows hostile names as text, is the same each time, and states what the diagnosis found."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np

from scalar.data.io.atomic import plain
from scalar.diagnosis import Diagnosis
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.planning.after import outcome, poses_after
from scalar.planning.candidates import draw_candidates
from scalar.planning.defaults import N_CANDIDATES, REPEATABILITY
from scalar.planning.questions import open_pairs
from scalar.planning.separation import ANSWERED
from scalar.planning.workcell import Workcell
from scalar.report import render_report, words
from scalar.report.further_poses import in_words
from scalar.report.opening import caution
from scalar.sensors.rows import stated_sigma
from tests.report.periodic_joint import HOSTILE_PLANE, JOINT, OF_RESIDUAL, ORDER

VOID = {"meta", "br", "img", "link", "input", "hr", "path", "polyline", "polygon"}


class Structure(HTMLParser):
    """Collects the tags and attributes of a page, and whether its tags are properly nested (``balanced``)."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.balanced = True

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        self.balanced &= bool(self.open) and self.open.pop() == tag


def structure(text: str) -> Structure:
    """Return the tags of a page."""
    parser = Structure()
    parser.feed(text)
    parser.close()
    return parser


def test_page_opens_offline(periodic_page: str) -> None:
    """Nothing is fetched and nothing runs: no links, no sources, no imports, no scripts, no handlers."""
    parser = structure(periodic_page)
    assert not {tag for tag, _ in parser.tags} & {
        "script",
        "link",
        "img",
        "iframe",
        "object",
        "embed",
        "a",
    }
    for tag, attributes in parser.tags:
        assert not {name for name in attributes if name.startswith("on")}
        assert not {"src", "xlink:href", "srcset", "xmlns"} & set(attributes)
        assert "href" not in attributes or (tag == "use" and str(attributes["href"]).startswith("#"))
        assert all("url(" not in str(v) or str(v).startswith("url(#") for v in attributes.values())
    style = re.search(r"<style>(.*?)</style>", periodic_page, re.DOTALL)
    assert style and "url(" not in style.group(1) and "@import" not in style.group(1)
    assert "http:" not in periodic_page and "https:" not in periodic_page


def test_identifiers_are_unique_and_resolved(periodic_page: str) -> None:
    """No two elements have the same identifier, and every reference within the page has its element."""
    tags = structure(periodic_page).tags
    names = [attributes["id"] for _, attributes in tags if "id" in attributes]
    assert len(set(names)) == len(names) > 0
    wanted = {str(a["href"])[1:] for _, a in tags if "href" in a}
    wanted |= {name for _, a in tags for name in re.findall(r"url\(#([^)]+)\)", str(a.get("clip-path", "")))}
    assert wanted <= set(names)


def test_page_is_well_formed(periodic_page: str) -> None:
    """Tags are properly nested; every picture is XML and has a description of what it shows."""
    parser = structure(periodic_page)
    assert parser.balanced and not parser.open
    pictures = re.findall(r'<svg viewBox="0 0 \d{3} .*?</svg>', periodic_page, re.DOTALL)
    assert len(pictures) == periodic_page.count("<svg")
    assert len(pictures) >= 4
    for picture in pictures:
        root = ElementTree.fromstring(picture)
        assert root.get("role") == "img"
        assert len(root.get("aria-label", "")) > 20


def test_hostile_names_stay_text(periodic_diagnosis: Diagnosis, periodic_page: str) -> None:
    """A name that contains markup is shown as text and opens no tag."""
    assert periodic_diagnosis.dataset.planes[0].name == HOSTILE_PLANE
    assert "<script" not in periodic_page and "<img" not in periodic_page
    assert "&lt;script&gt;" in periodic_page and "onerror" in periodic_page  # as letters, in the legend


def test_same_diagnosis_same_bytes(periodic_diagnosis: Diagnosis, periodic_page: str) -> None:
    """Nothing in the page depends on when or how often it is made."""
    assert render_report(periodic_diagnosis) == periodic_page


def test_numbers_in_the_page_are_those_of_the_diagnosis(
    periodic_diagnosis: Diagnosis, periodic_page: str
) -> None:
    """The page has the errors before and after as in diagnosis.json, to three digits."""
    residual = periodic_diagnosis.to_mapping()["residual"]
    for when in ("before", "after"):
        assert f"{words.number(residual[when]['held_out_rms_mm'])} mm" in periodic_page


def test_a_page_without_effects_claims_none(null_diagnosis: Diagnosis) -> None:
    """Without an effect there is one picture of the residual and no claim."""
    text = render_report(null_diagnosis)
    if null_diagnosis.verdict == "no_effect":
        assert "show nothing that the model lacks" in text
        assert "What was found" not in text
        assert len(re.findall(OF_RESIDUAL, text)) == 1


def test_a_candidate_of_which_the_poses_show_nothing_has_no_line(null_diagnosis: Diagnosis) -> None:
    """Where the noise hides all directions of a candidate its evidence is minus infinity; the table leaves it out, as ``diagnosis.json`` does."""
    first, *others = null_diagnosis.ranking
    hidden = replace(first, gain=0.0, dof=0, evidence=-np.inf, p_value=1.0)
    same_title = [entry for entry in others if entry.effect.title == first.effect.title]
    others = [entry for entry in others if entry not in same_title]
    for ranking in ((*others, hidden), (hidden,)):
        page = render_report(replace(null_diagnosis, ranking=ranking))
        table = page.split("<h2>The candidates</h2>")[1].split("<h2>")[0]
        assert f"<td>{words.capital(first.effect.title)}" not in table


def test_the_report_says_of_further_poses_what_the_plan_says(periodic_diagnosis: Diagnosis) -> None:
    """If two causes are confounded, the report states the sizes and the verdict of `scalar plan --after`, and its opening agrees with them."""
    (finding, *_) = periodic_diagnosis.findings
    rival = JointHarmonic(JOINT, (ORDER + 1,))
    doubted = replace(periodic_diagnosis, findings=(replace(finding, confounded_with=(rival,)),))
    sensor = periodic_diagnosis.dataset.sensor
    cell = Workcell.of(
        periodic_diagnosis.dataset.robot,
        replace(sensor, noise=stated_sigma(sensor.noise)),
        periodic_diagnosis.dataset.planes,
        doubted.calibration_after,
        repeatability=REPEATABILITY,
        same_campaign=True,
    )
    poses = draw_candidates(cell, N_CANDIDATES, np.random.default_rng(0), one_turn=True)
    calibration = doubted.calibration_after
    left = open_pairs(plain(doubted.to_mapping()), calibration.model.effects, periodic_diagnosis.dataset)
    after = poses_after(cell, poses, periodic_diagnosis.dataset, calibration, left)
    answer = next(a for p, a in zip(after.pairs, after.answers, strict=True) if p.rival is not None)
    said = in_words(doubted, doubted.findings[0])
    assert answer.now >= ANSWERED and "should distinguish it from" in said  # this rival was made up
    sizes = re.findall(r"[\d.]+", outcome(answer))
    assert len(sizes) == 2 and all(size in said for size in sizes)
    told = caution(doubted, doubted.findings[0])
    assert ("scalar plan FOLDER --after" in told) == answer.separable
