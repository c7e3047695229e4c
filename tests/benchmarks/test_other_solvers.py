"""Other solvers get the same problem and find the same optimum; one that is missing is named, and the others are compared all the same."""

import json
import re
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks import other_solvers
from benchmarks.contestants import Contest
from benchmarks.other_solvers import CERES, JAX, OURS, YARDSTICK, distance, other_ways, own_ways
from benchmarks.solvers import external
from benchmarks.solvers.external import MissingSolverError, Program, ceres_command, jax_command, problem_of
from benchmarks.solvers.problem_file import PlaneProblemFile
from benchmarks.timing import Times, in_turns, middle_half, ratio
from tests.kinematics import chain
from tests.random_scene import make_scene

NAMES = [*CERES.values(), *JAX.values()]
SAME = 1e-3  # standard errors: far below what any of them matters


def contest_of(robot="vs060", **others):
    """Return the contest of a small scene whose scans have different numbers of points."""
    given = {"poses_per_plane": 20, "plane_tilt": 0.05, "plane_offset": 0.01, "points_per_scan": (20, 60)}
    return Contest(make_scene(robot, **(given | others)).dataset)


@pytest.fixture(scope="module")
def contest():
    """Return the contest that the solvers are compared on."""
    return contest_of()


def weighted_distances(problem, vector):
    """Return the weighted distances ``(P,)`` of all points from their planes, from what a problem's file says and the tests' kinematics."""
    n, vector = problem.q.shape[1], np.array(vector)
    geometry = vector[: 5 * n].reshape(5, n)
    T_flange_sensor = np.eye(4)
    T_flange_sensor[:3, :3] = (
        Rotation.from_rotvec(vector[5 * n + 3 : 5 * n + 6]).as_matrix() @ problem.R_sensor
    )
    T_flange_sensor[:3, 3] = vector[5 * n : 5 * n + 3]
    T = chain(geometry, problem.q, problem.T_base_0) @ problem.T_n_flange @ T_flange_sensor
    u, v, d = vector[5 * n + 6 :].reshape(-1, 3).T
    normals = problem.normals + u[:, None] * problem.tangents[:, 0] + v[:, None] * problem.tangents[:, 1]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    pose = np.repeat(np.arange(len(T)), np.diff(problem.starts))
    points = np.column_stack([problem.x, 0 * problem.x, problem.z, np.ones_like(problem.x)])
    placed = np.einsum("pij,pj->pi", T[pose], points)[:, :3]
    plane = problem.plane[pose]
    return problem.w * (np.sum(normals[plane] * placed, axis=1) - d[plane])


@pytest.mark.parametrize("robot", ["vs060", "panda"])
def test_the_file_holds_the_same_problem(robot, tmp_path):
    """What a program reads gives the residuals of the contest, at the start and elsewhere, for an arm with a flange frame of its own as well."""
    contest = contest_of(robot)
    problem_of(contest).write(tmp_path / "problem.bin")
    problem = PlaneProblemFile.read(tmp_path / "problem.bin")
    np.testing.assert_array_equal(problem.start, contest.model.vector)
    elsewhere = problem.start + 1e-3 * np.random.default_rng(3).standard_normal(len(problem.start))
    for vector in (problem.start, elsewhere):
        expected = contest._all_points(contest.model.with_vector(vector))
        np.testing.assert_allclose(weighted_distances(problem, vector), expected, rtol=1e-9, atol=1e-7)


def test_a_file_that_ends_too_early_is_refused(contest, tmp_path):
    """A file without its last number is refused with the number of missing bytes."""
    path = tmp_path / "problem.bin"
    problem_of(contest).write(path)
    path.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(ValueError, match="8 bytes too early"):
        PlaneProblemFile.read(path)


def test_planes_that_are_held_are_refused(contest):
    """The programs free all coordinates of planes: a contest that holds one is not handed to them."""
    held = Contest(contest.dataset)
    held.free = held.free[:-1]
    with pytest.raises(ValueError, match="all coordinates are free"):
        problem_of(held)


def test_the_yardstick_finds_the_optimum(contest):
    """lmfit on all points and the fit of scalar end at the same parameters, with the same standard errors."""
    ways = own_ways(contest)
    slow, fast = ways[YARDSTICK]().result, ways[OURS]().result
    assert distance(slow, fast) < SAME
    np.testing.assert_allclose(slow.std, fast.std, rtol=1e-4)


@pytest.fixture(scope="module")
def others(contest, tmp_path_factory):
    """Return the ways of the other solvers; Ceres' program is not compiled here, which takes longer than all other tests of this file."""
    with ExitStack() as programs:
        yield other_ways(contest, tmp_path_factory.mktemp("problem"), programs, build=False)


@pytest.mark.slow  # where JAX is there, it compiles for ten seconds
@pytest.mark.parametrize("name", NAMES)
def test_other_solvers_find_the_optimum(name, contest, others):
    """Ceres and JAX end at the parameters and standard errors of scalar, whichever way points are grouped."""
    way = others[name]
    if isinstance(way, str):
        pytest.skip(f"{name}: {way}")
    found, ours = way().result, contest.proposed()
    assert distance(found, ours) < SAME
    np.testing.assert_allclose(found.std, ours.std, rtol=1e-6)


def fake(*lines):
    """Return a command that waits for a word and then runs lines of Python."""
    return [sys.executable, "-c", "\n".join(["import sys", "sys.stdin.readline()", *lines])]


def test_an_answer_is_read():
    """The numbers of a line of JSON become an answer; what the program does not say of compiling is zero."""
    line = json.dumps({"seconds": 0.5, "evaluations": 3, "peak_bytes": 7, "vector": [1.0, 2.0], "std": [0.1]})
    with Program(fake(f"print({line!r})")) as program:
        found = program.fit("pose")
    assert (found.seconds, found.evaluations, found.peak_bytes, found.compile_seconds) == (0.5, 3, 7, 0.0)
    assert (found.vector.tolist(), found.std.tolist()) == ([1.0, 2.0], [0.1])


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("sys.exit('first\\nno such way')", "no such way"),
        ("sys.exit(3)", "exit code 3"),
        ("print('{\"seconds\": nan}')", "cannot be read"),
    ],
)
def test_a_program_that_fails_says_why(line, said):
    """Instead of a hang or a traceback, what a program said last is the reason why it is left out."""
    with Program(fake(line)) as program, pytest.raises(MissingSolverError, match=said):
        program.fit("pose")


def test_what_is_missing_is_said(contest, tmp_path, monkeypatch):
    """No environment of JAX, no program, no compiler, no library: each is said, with what to do."""
    problem = problem_of(contest)
    with pytest.raises(MissingSolverError, match=r"JAX is missing .*make bench-solvers"):
        jax_command(tmp_path, tmp_path / "python")
    monkeypatch.setattr(external, "BUILT", tmp_path / "built")
    with pytest.raises(MissingSolverError, match=r"not built .*make bench-solvers"):
        ceres_command(problem, tmp_path, build=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(MissingSolverError, match=r"g\+\+ is missing"):
        ceres_command(problem, tmp_path)
    compiler = tmp_path / "g++"
    compiler.write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")
    compiler.chmod(0o755)
    with pytest.raises(MissingSolverError, match=r"Ceres is missing .*libceres-dev"):
        ceres_command(problem, tmp_path)


def test_the_table_goes_on_without_the_missing(contest, monkeypatch, capsys):
    """Solvers that cannot be had are left out with their reasons, and the others have their lines."""

    def missing(*_, **__):
        raise MissingSolverError("it is on another machine")

    monkeypatch.setattr(other_solvers, "ceres_command", missing)
    monkeypatch.setattr(other_solvers, "jax_command", lambda path: fake("sys.exit('no memory')"))
    other_solvers.other_solvers(1, contest)
    lines = {
        name: line
        for line in capsys.readouterr().out.splitlines()
        for name in [*NAMES, OURS]
        if line.startswith(name)
    }
    assert all("left out: it is on another machine" in lines[name] for name in CERES.values())
    assert all("left out: it ended: no memory" in lines[name] for name in JAX.values())
    assert "0.0e+00" in lines[OURS]


def test_contestants_take_turns():
    """Every contestant is called once before the first round, and once in each; the times are what the rounds' calls say."""
    calls = []

    def contestant(name, seconds):
        calls.append(name)
        return seconds * len(calls)

    times = in_turns({"a": lambda: contestant("a", 1.0), "b": lambda: contestant("b", 2.0)}, 3)
    assert calls == ["a", "b"] * 4
    assert (times["a"].seconds.tolist(), times["b"].seconds.tolist()) == ([3.0, 5.0, 7.0], [8.0, 12.0, 16.0])


def test_half_of_the_rounds_have_ratios_between_the_quartiles():
    """Ratios are taken within a round, so that a machine that slows both down does not change them."""
    slow, fast = Times(np.array([2.0, 6.0, 40.0, 8.0, 10.0])), Times(np.array([1.0, 2.0, 10.0, 2.0, 1.0]))
    assert (ratio(slow, fast), middle_half(slow, fast)) == (4.0, (3.0, 4.0))


def test_distances_are_counted_in_standard_errors(contest):
    """A parameter that is two of its standard errors away makes a distance of two, whatever its unit."""
    best = contest.proposed()
    moved = best.values.copy()
    moved[4] -= 2 * best.std[4]
    assert distance(replace(best, values=moved), best) == pytest.approx(2.0)


def test_the_peak_is_of_the_process_alone():
    """A small process that a large one starts does not report the memory of the large one."""
    large = np.ones(25_000_000)  # 200 MB
    command = "from benchmarks.peak_memory import peak_bytes; print(peak_bytes())"
    run = subprocess.run(
        [sys.executable, "-c", command], check=True, capture_output=True, text=True, cwd=external.ROOT
    )
    assert 1e6 < int(run.stdout) < 0.5 * large.nbytes


def test_jax_is_pinned_by_hashes():
    """Each package of JAX's environment has one version and its hashes, and the file names no address."""
    text = (external.ROOT / "benchmarks/solvers/requirements.txt").read_text(encoding="utf-8")
    entries = re.findall(r"^(\S.*?)(?<!\\)$", text.replace("\\\n", " "), flags=re.MULTILINE)
    packages = [entry for entry in entries if not entry.startswith("#")]
    assert {entry.partition("==")[0] for entry in packages} >= {"jax", "jaxlib", "numpy"}
    assert all("==" in entry and "--hash=sha256:" in entry for entry in packages)
    assert "://" not in text
