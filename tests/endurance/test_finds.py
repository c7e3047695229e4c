"""What the fuzzing found: each find as a test."""

import json
import random

import numpy as np
import pytest

from scalar.data.dataset import Dataset, read_dataset
from scalar.errors import InvalidInput
from scalar.ingest.bag.stops import find_stops
from scalar.ingest.urdf import robot_from_urdf
from tests.endurance.readers import READERS
from tests.random_scene import make_scene
from tests.robot_descriptions import random_description


@pytest.mark.parametrize("length", ["1e308", "1e200", "2", "-1e-3"])
def test_an_axis_of_any_length_is_a_direction(length, tmp_path):
    """An axis of any length gives the robot of the unit axis; the square of a long one once overflowed, and the axis became zero."""
    text = random_description(np.random.default_rng(3), 3)
    start = text.index('<axis xyz="') + len('<axis xyz="')
    end = text.index('"', start)
    robots = []
    for k, axis in enumerate((length, "-1" if length[0] == "-" else "1")):
        path = tmp_path / f"arm-{k}.urdf"
        path.write_text(f"{text[:start]}0 {axis} 0{text[end:]}")
        robots.append(robot_from_urdf(path, tip="tip")[0])
    np.testing.assert_allclose(robots[0].geometry, robots[1].geometry, atol=1e-12)


@pytest.mark.parametrize(
    "coefficients", [{"sin_rad": 1}, {"sin_rad": {"value": "x"}}, {"sin_rad": []}, [], "x", None]
)
def test_a_diagnosis_whose_coefficients_are_none_is_refused(coefficients, tmp_path):
    """A number, a text or a list in the place of a value with its standard error is refused as a fault of the file."""
    READERS["diagnosis"].make(tmp_path)
    content = json.loads((tmp_path / "diagnosis.json").read_text())
    content["effects"][0]["coefficients"] = coefficients
    (tmp_path / "diagnosis.json").write_text(json.dumps(content))
    try:
        READERS["diagnosis"].read(tmp_path)
    except InvalidInput as refusal:
        assert "damaged diagnosis" in str(refusal)


@pytest.mark.parametrize(
    ("file", "was", "now", "place"),
    [
        ("blind_trials_smoke.yaml", "unknown:\n  seeds: 1", "unknown:\n  seeds: 1000.0", "unknown.seeds"),
        ("blind_trials_smoke.yaml", "seeds_per_job: 1", "seeds_per_job: 1.0", "seeds_per_job"),
        ("blind_trials_stratified_smoke.yaml", "sets: 4\n", "sets: 4.0\n", "sets"),
        ("smoke.csv", ",14,", ",14.0,", "poses_per_plane"),
    ],
)
def test_a_number_with_a_point_is_no_count(file, was, now, place, tmp_path):
    """A count of 1000.0 is refused, although the JSON schema standard takes it for an integer, because counting with it once failed."""
    READERS["config and grids"].make(tmp_path)
    text = (tmp_path / file).read_text()
    assert was in text
    (tmp_path / file).write_text(text.replace(was, now, 1))
    with pytest.raises(InvalidInput, match=place):
        READERS["config and grids"].read(tmp_path)


def test_damage_is_the_same_from_the_same_seed():
    """The same seed gives the same damage, so that a find can be made again."""
    from tests.endurance.mutations import mutated

    raw = b"format: x\nvalues: [1.0, 2.0]\n"
    assert mutated(raw, random.Random(5)) == mutated(raw, random.Random(5))


@pytest.mark.parametrize("damage", [{}, {"held_out_before_mm": "x"}, {"effects": "another"}, {"status": 1}])
def test_a_damaged_result_of_a_batch_is_made_again(damage, tmp_path):
    """A damaged line of the table is made again; a line without a number once ended the batch, and a wrong number was accepted."""
    READERS["result of a batch"].make(tmp_path)
    path = tmp_path / "out" / "batch.json"
    content = json.loads(path.read_text())
    content["row"] = {**content["row"], **damage} if damage else {"status": 0}
    path.write_text(json.dumps(content))
    assert READERS["result of a batch"].read(tmp_path) is None


def test_a_position_that_is_no_number_is_no_stop():
    """A position that is NaN is no standstill; once it lasted until the recording ended, because NaN compares as unmoved."""
    times = np.arange(0.0, 6.0, 0.1)
    positions = np.where(times < 3.0, 0.0, 1.0)[:, None] * np.ones(2)
    whole = find_stops(times, positions)
    assert [stop.q.tolist() for stop in whole] == [[0.0, 0.0], [1.0, 1.0]]
    positions[0, 0] = positions[45, 1] = np.nan
    stops = find_stops(times, positions)
    assert [stop.q.tolist() for stop in stops] == [[0.0, 0.0], [1.0, 1.0], [1.0, 1.0]]
    assert find_stops(times, np.full((60, 2), np.nan)) == []
    signalling = np.frombuffer(np.uint64(0x7FF0000000000001).tobytes(), dtype=float)[
        0
    ]  # raises the flag of invalid operations
    positions[30] = signalling
    assert len(find_stops(times, positions)) == len(stops)


def test_a_reference_too_far_away_to_be_squared_is_refused(tmp_path):
    """A coordinate whose square overflows is too large a number; its distances to the others were computed all the same once."""
    scene = make_scene("vs060", "tracker", poses_per_plane=4)
    data = scene.dataset
    nests = {name: np.full((data.n_poses, 3), float(k)) for k, name in enumerate("abc")}
    dataset = Dataset.from_arrays(
        robot=data.robot, sensor=data.sensor, q=data.q, points=data.points, nests=nests
    )
    dataset.write(tmp_path / "cell")
    (path,) = (tmp_path / "cell").glob("nests.csv")
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[2] = ",".join([*lines[2].split(",")[:-1], "1e200"])
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(InvalidInput, match="too large a number"):
        read_dataset(tmp_path / "cell")


def test_references_that_no_file_may_hold_are_refused():
    """Names and arrays that a reader would refuse are refused before they are written; once they gave a folder that could not be read."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=4).dataset
    arrays = {"robot": dataset.robot, "sensor": dataset.sensor, "q": dataset.q, "points": dataset.points}
    n = dataset.n_poses
    for nests, words in (
        ({"nest 1": np.zeros((n, 3))}, r"not a name \('nest 1'\)"),
        ({"nest": np.zeros((n - 1, 3))}, f"write \\({n}, 3\\)"),
    ):
        with pytest.raises(InvalidInput, match=words):
            Dataset.from_arrays(**arrays, nests=nests)
    assert Dataset.from_arrays(**arrays, nests={"nest": np.zeros((n, 3))}).references is not None
