"""The benchmark on tracker data: what is handed over and read back, how it is scored, and what is said of a package that cannot be run."""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.trackers import environments, scene
from benchmarks.trackers.adapters.exchange import Answer, link, read_answer, read_job, write_answer, write_job
from benchmarks.trackers.contest import ADAPTERS, WAYS, Outcome, Way, answered, nominal_score, outcome, score
from benchmarks.trackers.environments import Missing, build, interpreter, last_line, pinned
from benchmarks.trackers.scene import nominal_positions, tracked_scene
from benchmarks.trackers.table import HEADER, row, table
from scalar import read_robot
from scalar.units import MM
from tests.kinematics import PARAMETER_KINDS, best_motion, chain, random_transform

PYTHON = Path(sys.executable)
ANSWER = Answer("1.2", [[0.0, 0.0, 0.0]] * 2, [0.5, 0.25], 26, 4, "steps", "yes")
STUB = """
import sys
sys.path.insert(0, {adapters!r})
from exchange import Fitted, run
import numpy as np
def fit(job):
    {body}
run("numpy", fit)
"""
ANSWERED = "return Fitted(lambda q: np.tile(job.measured[0], (len(q), 1)), 26, 4, 'steps', 'no')"


@pytest.fixture(scope="module")
def drawn():
    """Return one scene."""
    return tracked_scene(3)


def way(folder: Path, body: str, package: str | None = "stub") -> Way:
    """Return a way whose adapter is a stub with the body of its ``fit``."""
    path = folder / "fit_stub.py"
    path.write_text(STUB.format(adapters=str(ADAPTERS), body=body), encoding="utf-8")
    return Way("stub", path, package)


def test_a_job_is_read_as_it_was_written_and_holds_no_truth(drawn, tmp_path):
    """All digits arrive, and no number of the true positions at the test poses is in the file."""
    write_job(tmp_path / "job.json", drawn.job)
    for key, value in vars(read_job(tmp_path / "job.json")).items():
        np.testing.assert_array_equal(value, getattr(drawn.job, key))
    text = (tmp_path / "job.json").read_text(encoding="utf-8")
    assert repr(float(drawn.job.measured[0, 0])) in text
    assert not [x for x in drawn.truth.ravel().tolist() if repr(x) in text]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"predicted": [[0.0, 0.0, 0.0]]}, "2 positions were asked for"),
        ({"predicted": [[0.0, 0.0, 0.0], [0.0, float("nan"), 0.0]]}, "not finite"),
        ({"predicted": [[0.0, 0.0], [0.0, 0.0]]}, "shape"),
        ({"surprise": 1}, "other fields"),
    ],
)
def test_an_answer_to_another_question_is_refused(tmp_path, change, said):
    """Too few positions, a number that is not finite, planar positions and unknown fields are no answer; the unchanged answer is one."""
    path = tmp_path / "answer.json"
    write_answer(path, ANSWER)
    assert read_answer(path, 2) == ANSWER
    path.write_text(json.dumps(json.loads(path.read_text(encoding="utf-8")) | change), encoding="utf-8")
    with pytest.raises(ValueError, match=said):
        read_answer(path, 2)


def test_errors_are_distances():
    """Positions that are off by (3, 4, 0) mm and by nothing have 5 mm at most, and their root mean square."""
    truth = np.arange(6.0).reshape(2, 3)
    found = score(truth + np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 0.0]]) * MM, truth)
    assert found.largest == pytest.approx(5 * MM)
    assert found.rms == pytest.approx(5 * MM / np.sqrt(2))


def test_an_adapter_is_run_timed_and_scored(drawn, tmp_path):
    """An adapter in a process of its own answers the job; what it predicts is compared with the truth."""
    found = outcome(way(tmp_path, ANSWERED), drawn, PYTHON)
    assert isinstance(found, Outcome)
    said = (found.answer.parameters, found.answer.evaluations, found.answer.counted)
    assert said == (26, 4, "steps") and found.answer.standard_errors == "no"
    assert found.answer.version == np.__version__ and len(found.answer.seconds) == 2
    expected = np.linalg.norm(drawn.truth - drawn.job.measured[0], axis=1)
    assert found.score.largest == pytest.approx(expected.max(), rel=1e-12)
    assert found.score.rms == pytest.approx(np.sqrt(np.mean(expected**2)), rel=1e-12)


def test_the_fit_starts_anew_each_time(drawn, tmp_path):
    """Each of the timed fits gets the job as it was, also if an earlier one changed what it was given."""
    body = "assert job.measured[0, 0] != 1e6, 'was here'; job.measured[:] = 1e6; " + ANSWERED
    found = outcome(way(tmp_path, body), drawn, PYTHON)
    assert isinstance(found, Outcome), found


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("raise RuntimeError('the Jacobian is singular')", "failed: RuntimeError: the Jacobian is singular"),
        ("return Fitted(lambda q: q * np.nan, 1, None, '', '')", "no valid answer"),
        ("sys.exit(0)", "no valid answer"),
    ],
)
def test_an_adapter_that_fails_is_said(drawn, tmp_path, body, said):
    """A crash, a wrong answer and no answer are words in the table, and no error of the benchmark."""
    found = outcome(way(tmp_path, body), drawn, PYTHON)
    assert isinstance(found, Missing) and found.reason.startswith(said)


def test_foreign_adapters_do_not_see_this_checkout(drawn, tmp_path, monkeypatch):
    """The path of modules of the benchmark is that of the adapter of scalar alone."""
    body = "import os; raise RuntimeError(os.environ.get('PYTHONPATH', 'nothing'))"
    monkeypatch.setenv("PYTHONPATH", "elsewhere")
    foreign = answered(way(tmp_path, body), drawn.job, PYTHON, tmp_path)
    own = answered(way(tmp_path, body, None), drawn.job, PYTHON, tmp_path)
    assert isinstance(foreign, Missing) and foreign.reason.endswith(": nothing")
    assert isinstance(own, Missing) and own.reason.endswith(str(ADAPTERS.parents[2]))


def test_a_missing_environment_is_said_with_the_version(drawn, tmp_path):
    """Where nothing was installed, the table says which version is wanted and what installs it."""
    found = outcome(WAYS[-1], drawn, interpreter("figaroh", tmp_path))
    assert isinstance(found, Missing)
    line = table([row("figaroh", [found])]).splitlines()[-1]
    assert re.search(r"figaroh==[\d.]+ is not installed: make bench-trackers", line)
    assert line.count("|") == len(HEADER) + 1


def test_an_environment_that_cannot_be_made_leaves_the_reason(tmp_path):
    """A failed installation leaves no half environment, but the reason, until one succeeds; a made one is not made again."""
    commands = []

    def fails(command):
        commands.append(command)
        if "pip" in command:
            raise environments.CommandFailed("no matching distribution")
        (tmp_path / "pybotics").mkdir()

    build("pybotics", tmp_path, fails)
    assert not (tmp_path / "pybotics").exists()
    reason = f"{pinned('pybotics')} could not be installed: no matching distribution"
    assert interpreter("pybotics", tmp_path) == Missing(reason)
    assert "--require-hashes" in commands[-1]

    def works(command):
        commands.append(command)
        (tmp_path / "pybotics").mkdir(exist_ok=True)

    build("pybotics", tmp_path, works)
    assert interpreter("pybotics", tmp_path) == tmp_path / "pybotics/bin/python"
    count = len(commands)
    build("pybotics", tmp_path, works)
    assert len(commands) == count


def test_an_environment_of_other_requirements_is_made_again(tmp_path, monkeypatch):
    """What was installed from requirements that have changed since does not count."""
    monkeypatch.setattr(environments, "REQUIREMENTS", tmp_path)
    (tmp_path / "pybotics.txt").write_text("pybotics==1.0\n", encoding="utf-8")
    build("pybotics", tmp_path, lambda command: (tmp_path / "pybotics").mkdir(exist_ok=True))
    assert not isinstance(interpreter("pybotics", tmp_path), Missing)
    (tmp_path / "pybotics.txt").write_text("pybotics==2.0\n", encoding="utf-8")
    assert interpreter("pybotics", tmp_path).reason.startswith("pybotics==2.0 is not installed")


def test_a_reason_names_no_address():
    """Messages of installers name the address that they asked; the table does not."""
    assert (
        last_line("one\nERROR: nothing at https://packages.example/simple for x\n\n")
        == "ERROR: nothing at ... for x"
    )
    assert last_line(" \n") == "it said nothing"


def test_scenes_that_failed_are_said_beside_those_that_did_not(drawn):
    """A way that answered some scenes has their figures, how many they are, and why the rest is missing."""
    predicted = np.array(ANSWER.predicted)
    found = Outcome(ANSWER, score(predicted, predicted + np.array([2 * MM, 0.0, 0.0])))
    more = replace(found, answer=replace(ANSWER, evaluations=9))
    cells = row("stub", [found, Missing("no answer after 600 s"), more])
    assert cells[0] == "stub (2 of 3 scenes; no answer after 600 s)"
    assert cells[2:5] == ("2.0000", "2.0000 to 2.0000", "2.000")
    assert cells[7:9] == ("4 to 9 steps", "26")
    assert row("stub", [replace(found, answer=replace(ANSWER, evaluations=None))])[7] == ""


def test_the_true_arm_errs_by_as_much_as_stated(monkeypatch):
    """Every length errs by 0.1 to 0.5 mm and every angle by 1 to 2 mrad; beta errs for the third axis alone, and only if it is tilted."""
    seen = []
    original = scene.positions
    monkeypatch.setattr(scene, "positions", lambda *given: seen.append(given[0]) or original(*given))
    for tilted in (False, True):
        seen.clear()
        tracked_scene(5, tilted=tilted)
        true, nominal = seen[0], seen[1]
        errors = dict(zip(PARAMETER_KINDS, np.abs(true - nominal), strict=True))
        beta = errors.pop("beta")
        for kind, values in errors.items():
            low, high = (0.1 * MM, 0.5 * MM) if kind in ("a", "d") else (1e-3, 2e-3)
            assert np.all((values >= low * 0.999) & (values <= high * 1.001)), kind
        assert np.flatnonzero(beta).tolist() == ([2] if tilted else [])


def test_the_start_is_the_frame_of_the_nominal_arm(drawn):
    """Kabsch's frame takes exact places to where they were moved, and the nominal arm in it is off by millimetres, not by metres."""
    rng = np.random.default_rng(1)
    places, T = rng.standard_normal((9, 3)), random_transform(rng, 2.0, 2.5)
    np.testing.assert_allclose(best_motion(places, places @ T[:3, :3].T + T[:3, 3]), T, atol=1e-12)
    assert 0.2 * MM < nominal_score(drawn).rms < 10 * MM


def test_a_link_of_the_adapters_is_one_of_the_studies(drawn):
    """The links from which adapters build their models have the convention of the data."""
    geometry = np.zeros((5, 1))
    geometry[:4, 0] = a, alpha, d, theta = 0.3, -1.2, 0.2, 0.7
    np.testing.assert_allclose(
        link(alpha, a, theta + 0.4, d), chain(geometry, np.array([[0.4]]))[0], atol=1e-15
    )


def test_the_urdf_of_the_adapters_is_the_nominal_arm(drawn, tmp_path, monkeypatch):
    """A reader of URDF that the adapters do not use places the flange where the table has it."""
    monkeypatch.syspath_prepend(str(ADAPTERS))
    from arm_urdf import FLANGE, urdf

    (tmp_path / "arm.urdf").write_text(urdf(drawn.job), encoding="utf-8")
    robot = read_robot(tmp_path / "arm.urdf", tip=FLANGE)
    T = robot.flange(drawn.job.q)
    at = T[:, :3, :3] @ drawn.job.reflector + T[:, :3, 3]
    base = replace(drawn.job, T_tracker_base=np.eye(4))
    np.testing.assert_allclose(at, nominal_positions(base, drawn.job.q), atol=1e-9)


def test_scalar_gives_the_truth_back_without_noise():
    """The adapter of scalar, as the others a process of its own, predicts the test poses of an arm without noise to 10 nm."""
    exact = tracked_scene(2, noise=0.0)
    exact = replace(exact, job=replace(exact.job, noise=1e-6))
    found = outcome(WAYS[0], exact, PYTHON)
    assert isinstance(found, Outcome), found
    assert found.score.largest < 1e-8
    assert found.answer.parameters == 26


def test_every_package_is_pinned_with_hashes():
    """Requirements name exact versions with hashes, and no address of a registry; each adapter belongs to a package with requirements."""
    for package in environments.PACKAGES:
        text = (environments.REQUIREMENTS / f"{package}.txt").read_text(encoding="utf-8")
        blocks = re.split(
            r"\n(?=\S)", "\n".join(line for line in text.splitlines() if not line.startswith("#"))
        )
        assert blocks and all(
            re.match(r"[\w.-]+==\S+", block) and "--hash=sha256:" in block for block in blocks
        )
        assert "://" not in text and "index" not in text
    assert {way.package for way in WAYS} == {None, *environments.PACKAGES}
    assert all(way.adapter.is_file() for way in WAYS)
