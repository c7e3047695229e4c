"""The report opens offline, shows hostile names as text, is the same each time, and its pictures show what was injected."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

from scalar.cli.diagnose import describe_diagnosis
from scalar.data.dataset import Dataset
from scalar.data.io.atomic import plain
from scalar.diagnosis import Diagnosis, diagnose
from scalar.diagnosis.partial_residuals import FittedView
from scalar.diagnosis.scan_residuals import signed_residual
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.picture import Map, Profile
from scalar.planning.after import outcome, poses_after
from scalar.planning.candidates import draw_candidates
from scalar.planning.defaults import N_CANDIDATES, REPEATABILITY
from scalar.planning.questions import open_pairs
from scalar.planning.workcell import Workcell
from scalar.report import render_report, words
from scalar.report.further_poses import in_words
from scalar.report.opening import caution
from scalar.sensors.rows import stated_sigma
from scalar.units import MM
from tests.random_scene import make_scene

JOINT, ORDER, AMPLITUDE, PHASE = 4, 3, 6e-4, 0.7
HOSTILE = "</title><script>alert(1)</script>"
HOSTILE_PLANE = "\"><img src=//x onerror='alert(1)'>&"
OF_RESIDUAL = r'aria-label="[^"]* in order of acquisition'
VOID = {"meta", "br", "img", "link", "input", "hr", "path", "polyline", "polygon"}


def injected(q: np.ndarray) -> np.ndarray:
    """Return the error of the joint's angle at encoder angles [rad]."""
    return AMPLITUDE * np.sin(ORDER * q + PHASE)


def hostile(dataset: Dataset) -> Dataset:
    """Return a dataset whose names try to break out of the page."""
    renamed = replace(dataset.planes[0], name=HOSTILE_PLANE)
    poses = dataset.poses.copy()
    poses["plane"] = poses["plane"].replace({dataset.planes[0].name: HOSTILE_PLANE})
    robot = replace(dataset.robot, name=HOSTILE)
    return replace(dataset, name=HOSTILE, robot=robot, planes=(renamed, *dataset.planes[1:]), poses=poses)


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    """Return the diagnosis of a cell in which one joint errs periodically, its names hostile."""
    dataset = make_scene(seed=3, poses_per_plane=45, points_per_scan=30).dataset
    poses = dataset.poses.copy()
    # The encoder reads q where the arm stands at q + injected(q): solved by iteration.
    stands = poses[f"q{JOINT}"].to_numpy()
    reads = stands.copy()
    for _ in range(20):
        reads = stands - injected(reads)
    poses[f"q{JOINT}"] = reads
    return diagnose(hostile(replace(dataset, poses=poses)))


@pytest.fixture(scope="module")
def nothing() -> Diagnosis:
    """Return the diagnosis of a cell in which nothing was injected."""
    return diagnose(make_scene(seed=4, poses_per_plane=30, points_per_scan=20).dataset)


@pytest.fixture(scope="module")
def page(found: Diagnosis) -> str:
    return render_report(found)


class Structure(HTMLParser):
    """Collects tags and attributes, and whether every tag that opens is closed in its turn."""

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
    parser = Structure()
    parser.feed(text)
    parser.close()
    return parser


def view_of(diagnosis: Diagnosis) -> FittedView:
    after = diagnosis.calibration_after
    return FittedView.of(diagnosis.after, after.free, after.covariance)


def pictures_of(diagnosis: Diagnosis) -> list[Profile | Map]:
    """Return the pictures of the first effect."""
    return diagnosis.after.effects[0].pictures(view_of(diagnosis))


def test_the_injected_effect_is_named(found: Diagnosis) -> None:
    """The injected harmonic, which the other tests need, is found with its joint and order."""
    assert [f.effect.target for f in found.findings if isinstance(f.effect, JointHarmonic)] == [
        {"joint": JOINT, "order": ORDER}
    ]


def test_page_opens_offline(page: str) -> None:
    """Nothing is fetched and nothing runs: no links, no sources, no imports, no scripts, no handlers."""
    parser = structure(page)
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
    style = re.search(r"<style>(.*?)</style>", page, re.DOTALL)
    assert style and "url(" not in style.group(1) and "@import" not in style.group(1)
    assert "http:" not in page and "https:" not in page


def test_identifiers_are_unique_and_resolved(page: str) -> None:
    """No two elements have the same identifier, and every reference within the page has its element."""
    tags = structure(page).tags
    names = [attributes["id"] for _, attributes in tags if "id" in attributes]
    assert len(set(names)) == len(names) > 0
    wanted = {str(a["href"])[1:] for _, a in tags if "href" in a}
    wanted |= {name for _, a in tags for name in re.findall(r"url\(#([^)]+)\)", str(a.get("clip-path", "")))}
    assert wanted <= set(names)


def test_a_dot_tells_its_pose_and_value(nothing: Diagnosis) -> None:
    """In the picture of the residual every pose has a dot, and the dot says the pose, the place and the
    residual in millimetres."""
    said = re.findall(r"<title>pose (\d+) at order ([\d.]+): (\S+) mm</title>", render_report(nothing))
    state = nothing.after
    poses, residual = state.dataset.poses["pose"].to_numpy(), signed_residual(state) / MM
    expected = {
        int(p): (float(o), r) for p, o, r in zip(poses, state.residuals.poses.order, residual, strict=True)
    }
    pictures = len(re.findall(OF_RESIDUAL, render_report(nothing)))
    assert {int(p) for p, _, _ in said} == set(expected)
    if pictures == 1:
        assert len(said) == len(expected)
        for pose, order, value in said:
            assert float(order) == pytest.approx(expected[int(pose)][0])
            assert float(value.replace("−", "-")) == pytest.approx(expected[int(pose)][1], rel=6e-3)


def test_bars_of_the_errors_have_one_scale(found: Diagnosis, page: str) -> None:
    """The four bars of errors, all in millimetres, are as long as their numbers say, to a pixel or so."""
    residual = found.to_mapping()["residual"]
    keys = [(w, k) for k in ("held_out_rms_mm", "held_out_max_mm") for w in ("before", "after")]
    values = np.array([residual[w][k] for w, k in keys])
    widths = np.array(
        [float(w) for w in re.findall(r'<i class="(?:before|after)" style="width:([\d.]+)%"', page)]
    )
    np.testing.assert_allclose(widths / widths.max(), values / values.max(), atol=0.002)


def test_page_is_well_formed(page: str) -> None:
    """Every tag that opens is closed in its turn; every picture is XML and says in words what it shows."""
    parser = structure(page)
    assert parser.balanced and not parser.open
    pictures = re.findall(r'<svg viewBox="0 0 \d{3} .*?</svg>', page, re.DOTALL)
    assert len(pictures) == page.count("<svg")
    assert len(pictures) >= 4
    for picture in pictures:
        root = ElementTree.fromstring(picture)
        assert root.get("role") == "img"
        assert len(root.get("aria-label", "")) > 20


def test_hostile_names_stay_text(found: Diagnosis, page: str) -> None:
    """A name that holds markup is shown as it is and opens no tag."""
    assert found.dataset.planes[0].name == HOSTILE_PLANE
    assert "<script" not in page and "<img" not in page
    assert "&lt;script&gt;" in page and "onerror" in page  # as letters, in the legend


def test_same_diagnosis_same_bytes(found: Diagnosis, page: str) -> None:
    """Nothing in the page depends on when or how often it is made."""
    assert render_report(found) == page


def test_numbers_in_the_page_are_those_of_the_diagnosis(found: Diagnosis, page: str) -> None:
    """The errors before and after stand in the page as in diagnosis.json, to three digits."""
    residual = found.to_mapping()["residual"]
    for when in ("before", "after"):
        assert f"{words.number(residual[when]['held_out_rms_mm'])} mm" in page


def test_nothing_found_is_said(nothing: Diagnosis) -> None:
    """Without an effect there is one picture of the residual and no claim."""
    text = render_report(nothing)
    if nothing.verdict == "no_effect":
        assert "show nothing that the model lacks" in text
        assert "What was found" not in text
        assert len(re.findall(OF_RESIDUAL, text)) == 1


def test_curve_is_the_injected_one(found: Diagnosis) -> None:
    """The fitted curve of the picture is the injected error of the joint within five of its own standard
    errors."""
    course = pictures_of(found)[0]
    assert isinstance(course, Profile) and course.curve is not None
    x, curve, std = course.curve
    assert np.all(np.abs(curve - injected(x)) < 5 * std + 1e-6)
    assert np.ptp(curve) > 1.5 * AMPLITUDE


def test_dots_scatter_about_the_injected_curve_as_their_errors_say(found: Diagnosis) -> None:
    """The dot of each pose less the injected error there has the standard error that the picture states for it."""
    course = pictures_of(found)[0]
    assert isinstance(course, Profile)
    z = (course.y - injected(found.after.residuals.poses.q[:, JOINT - 1])) / course.std
    np.testing.assert_allclose(course.y - course.rest, course.fitted, rtol=0, atol=1e-15)
    assert 0.7 < 1.4826 * np.median(np.abs(z)) < 1.4


def test_added_variable_plot_has_slope_one(found: Diagnosis) -> None:
    """Given all other parameters, measured against predicted shift has a slope near one, since the residual is orthogonal."""
    course = view_of(found).added_variable(found.after.effects[0])
    slope = np.sum(course.x * course.y / course.std**2) / np.sum(course.x**2 / course.std**2)
    assert slope == pytest.approx(1.0, abs=0.1)


def test_seen_share_is_the_projection(found: Diagnosis) -> None:
    """The share from the Gram matrix is that of the signal with its least-squares fit by all other
    columns removed."""
    state = found.after
    jacobian = state.linearised()[1]
    effect = state.effects[0]
    start = int(state.free[: state.model.blocks["effects"].start].sum())
    mine = np.zeros(jacobian.shape[1], dtype=bool)
    mine[start : start + len(effect.coefficients)] = True
    signal = jacobian[:, mine] @ effect.coefficients
    scale = np.linalg.norm(jacobian, axis=0)
    others = (jacobian / scale)[:, ~mine]
    left = signal - others @ np.linalg.lstsq(others, signal, rcond=None)[0]
    expected = np.linalg.norm(left) / np.linalg.norm(signal)
    assert view_of(found).share_left(found.after.effects[0]) == pytest.approx(expected, rel=1e-4)


def test_the_report_says_of_further_poses_what_the_plan_says(found: Diagnosis) -> None:
    """Where two causes are confounded, the report has the sizes and the verdict of `scalar plan --after`, and the opening follows it."""
    (finding, *_) = found.findings
    rival = JointHarmonic(JOINT, (ORDER + 1,))
    doubted = replace(found, findings=(replace(finding, confounded_with=(rival,)),))
    sensor = found.dataset.sensor
    cell = Workcell.of(
        found.dataset.robot,
        replace(sensor, noise=stated_sigma(sensor.noise)),
        found.dataset.planes,
        doubted.calibration_after,
        repeatability=REPEATABILITY,
        same_campaign=True,
    )
    poses = draw_candidates(cell, N_CANDIDATES, np.random.default_rng(0))
    calibration = doubted.calibration_after
    left = open_pairs(plain(doubted.to_mapping()), calibration.model.effects, found.dataset)
    after = poses_after(cell, poses, found.dataset, calibration, left)
    answer = next(a for p, a in zip(after.pairs, after.answers, strict=True) if p.rival is not None)
    assert outcome(answer).replace("->", "→") in in_words(doubted, doubted.findings[0])
    told = caution(doubted, doubted.findings[0])
    assert ("scalar plan FOLDER --after" in told) == answer.separable


def test_many_coefficients_are_summed_up_in_the_terminal(
    found: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where more coefficients were found than a line holds, it says how far the effect goes in all, as the report does."""
    monkeypatch.setattr("scalar.cli.diagnose._COEFFICIENTS_SHOWN", 1)
    line = next(line for line in describe_diagnosis(found).splitlines() if "more coefficients" in line)
    assert re.search(r", up to 0\.\d+ deg: ", line)


def test_terminal_summary_is_short_and_plain(found: Diagnosis, nothing: Diagnosis) -> None:
    """About ten lines, in letters that any terminal has (names apart)."""
    for diagnosis in (found, nothing):
        text = describe_diagnosis(diagnosis)
        assert len(text.splitlines()) <= 14
        assert text.isascii()
