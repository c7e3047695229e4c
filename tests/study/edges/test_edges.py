"""The study of spoiled data: each axis adds its own fault only, answers are judged by name and joint, and edges are found in the curves."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from study.edges.axes import AXES
from study.edges.run import EDGE_COLUMNS, answer, is_right, run_edges
from study.edges.summary import ANSWERS, SUMMARY_COLUMNS, edge_numbers, summarise_edges
from study.plots.edges import draw_edges

from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import Undetermined
from tests.random_scene import make_scene

PAPER = Path(__file__).parents[3] / "configs" / "scenes" / "paper.yaml"
GEAR = {"name": "joint_harmonic", "target": {"joint": 2, "order": 1}}


@pytest.fixture(scope="module")
def dataset():
    """Return scans of three planes."""
    return make_scene(seed=1, poses_per_plane=20, points_per_scan=10).dataset


def same_poses(one, other):
    """Return whether two datasets have the same table of poses, whatever the types of its columns."""
    return one.poses.to_dict("list") == other.poses.to_dict("list")


@pytest.mark.parametrize("axis", AXES)
def test_nothing_is_changed_where_nothing_is_wrong(axis, dataset):
    """At the scene's own value the dataset is not changed, and the errors of the guesses are those of the scene."""
    wrong = AXES[axis]
    assert wrong.scene_value in wrong.values
    same = wrong.spoil(dataset, wrong.scene_value, np.random.default_rng(0))
    np.testing.assert_array_equal(same.points, dataset.points)
    assert same_poses(same, dataset) and same.sensor.noise == dataset.sensor.noise
    scene = {f"plane_guess.{key}": value for key, value in load_yaml(PAPER)["plane_guess"].items()}
    assert all(value == scene[key] for key, value in wrong.overrides(wrong.scene_value).items())


def test_the_sound_dataset_is_diagnosed_once(monkeypatch, capsys):
    """The dataset without a fault is diagnosed once, and has a row in every axis; each other degree is diagnosed by itself."""
    pytest.importorskip("pybullet")
    made = []
    monkeypatch.setattr(
        "study.edges.run.answer",
        lambda make, *_: {"answer": f"answer {len(made)}", **(made.append(make()) or {})},
    )
    table = run_edges(PAPER, {"outliers": [0.0, 10.0], "noise": [1.0, 3.0], "tilt": [1.0]}, [1])
    assert len(table) == 10 and len(made) == 6 and table["answer"].nunique() == 6
    sound = table[
        [value == AXES[axis].scene_value for axis, value in zip(table["axis"], table["value"], strict=True)]
    ]
    assert sound.groupby("injected")["answer"].nunique().eq(1).all() and len(sound) == 6


def test_each_axis_spoils_what_it_names(dataset):
    """The shares of stray points, wrong labels and missing poses, and the ratio of the stated noise, are those of the axis."""
    rng = np.random.default_rng
    strayed = AXES["outliers"].spoil(dataset, 30.0, rng(0))
    moved = np.any(strayed.points != dataset.points, axis=1)
    assert 0.2 < moved.mean() < 0.4 and same_poses(strayed, dataset)
    labelled = AXES["labels"].spoil(dataset, 10.0, rng(0))
    assert (labelled.poses["plane"] != dataset.poses["plane"]).sum() == round(0.1 * dataset.n_poses)
    fewer = AXES["missing"].spoil(dataset, 85.0, rng(0))
    last = dataset.planes[-1].name
    assert (fewer.poses["plane"] == last).sum() == 3 and fewer.n_poses == dataset.n_poses - 17
    assert AXES["noise"].spoil(dataset, 3.0, rng(0)).sensor.noise == pytest.approx(3 * dataset.sensor.noise)


def test_an_answer_is_right_by_name_and_joint():
    """Another order of the same gear is the same place; another joint, something more or something less is wrong; noises do not count."""
    assert is_right([], []) and is_right([{**GEAR, "target": {"joint": 2, "order": 3}}], [GEAR])
    assert is_right([GEAR, {"name": "scan_bias", "target": {}}], [GEAR])
    for found in (
        [],
        [{**GEAR, "target": {"joint": 3, "order": 1}}],
        [GEAR, {"name": "plane_bow", "target": {}}],
    ):
        assert not is_right(found, [GEAR])


def test_a_refusal_keeps_its_reason_and_a_crash_is_counted(capsys):
    """A refusal has its reason in the row, a crash is counted, and neither stops the other sets."""

    def refuse():
        raise Undetermined(["no plane: measure one", "and more"])

    assert answer(refuse, [], pd.DataFrame()) == {"answer": "refused", "reason": "no plane: measure one"}
    assert answer(lambda: 1 / 0, [], pd.DataFrame())["answer"] == "crashed"
    assert "ZeroDivisionError" in capsys.readouterr().err


def rows() -> pd.DataFrame:
    """Return made-up rows: sound up to 10 %, twice as bad at 20 %, refused at 30 %; a noise that may be understated, not overstated."""
    made = []
    for axis, value, position, said in (
        ("outliers", 0.0, 0.010, "right"),
        ("outliers", 10.0, 0.018, "right"),
        ("outliers", 20.0, 0.050, "wrong"),
        ("outliers", 30.0, None, "refused"),
        ("noise", 0.1, 0.011, "wrong"),
        ("noise", 1.0, 0.010, "right"),
        ("noise", 10.0, 0.090, "wrong"),
    ):
        made += [
            {"axis": axis, "value": value, "seed": seed, "answer": said, "position_after_mm": position}
            for seed in (1, 2)
        ]
    return pd.DataFrame(made).reindex(columns=list(EDGE_COLUMNS))


def test_shares_add_up_and_edges_are_found():
    """The answers of each value are all there; an edge is the last value before the first bad one, on either side of the sound one."""
    summary = summarise_edges(rows())
    assert list(summary.columns) == list(SUMMARY_COLUMNS) and next(iter(summary["axis"])) == "outliers"
    np.testing.assert_allclose(summary[list(ANSWERS)].sum(axis=1), 1.0)
    numbers = edge_numbers(summary)
    assert numbers["outliers"]["above"] == {
        "accurate_to": 10.0,
        "right_to": 10.0,
        "refused_from": 30.0,
        "crashed": 0.0,
    }
    assert numbers["sets"] == 2 and numbers["sound"] == {"position_worst_mm": 0.010}
    assert numbers["outliers"]["at"]["30"]["refused"] == 1.0
    assert numbers["outliers"]["at"]["30"]["position_worst_mm"] is None
    assert numbers["noise"]["at"]["0_1"]["position_worst_mm"] == 0.011
    assert numbers["noise"]["below"]["accurate_to"] == 0.1 and numbers["noise"]["below"]["right_to"] == 1.0
    assert numbers["noise"]["above"]["accurate_to"] == 1.0


def test_structure_that_is_found_without_a_name_is_no_wrong_name():
    """Unattributed structure is no wrong name where a gear error was injected, and is a false alarm where nothing was."""
    table = rows().query("axis == 'outliers' and value == 20").assign(verdict="unattributed")
    for injected, said in (("gear", "unattributed"), ("nothing", "wrong")):
        assert summarise_edges(table.assign(injected=injected))[said].tolist() == [1.0]


def test_the_figure_shows_every_axis_with_its_unit():
    """The figure has a panel of errors and a panel of answers for each axis that has rows, and no other."""
    figure = draw_edges(rows(), summarise_edges(rows()))
    labels = [ax.get_xlabel() for ax in figure.axes if ax.get_xlabel()]
    assert labels == [AXES["outliers"].label, AXES["noise"].label]
    assert len(figure.axes) == 4
