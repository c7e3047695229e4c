"""The questions that a diagnosis leaves open are read from its file as it judged them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.io.atomic import plain
from scalar.diagnosis.naming.observability import Unobservable
from scalar.effects.flexible.link import UnattributedLink
from scalar.effects.flexible.variable import GRAVITY
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.calibrate import calibrate
from scalar.planning.candidates import draw_candidates
from scalar.planning.questions import Pair, open_pairs, open_questions
from scalar.planning.workcell import Workcell
from tests.random_scene import make_scene


def test_an_unobservable_backlash_is_asked_for_as_it_was_judged() -> None:
    """A backlash whose side is known from the moves may be observable where one known from the torque's sign is not: poses are planned for
    the one that was judged unobservable.
    """
    dataset = make_scene("vs060", "tracker", seed=2, poses_per_plane=6).dataset
    both = [
        e
        for e in JointBacklash.candidates(dataset)
        if isinstance(e, JointBacklash) and e.target["joint"] == 2
    ]
    assert [effect.by for effect in both] == ["moves", "torque"]
    for judged in both:
        entry = plain(Unobservable(judged, 1e-3, 1e-4, "").to_mapping())
        (pair,), beyond = open_pairs({"effects": [], "unobservable": [entry]}, (), dataset)
        assert isinstance(pair.effect, JointBacklash) and not beyond
        assert pair.effect.by == judged.by and pair.effect.masses == judged.masses
    entries = [plain(Unobservable(judged, 1e-3, 1e-4, "").to_mapping()) for judged in both]
    pairs, _ = open_pairs({"effects": [], "unobservable": entries}, (), dataset)
    assert len(pairs) == 2


def test_a_diagnosis_of_an_earlier_version_is_read() -> None:
    """Without settings the effect is the first candidate with the name and target."""
    dataset = make_scene("vs060", "tracker", seed=2, poses_per_plane=6).dataset
    entry = {"name": "joint_backlash", "target": {"joint": 2}, "observability": 1e-3, "consequence": ""}
    (pair,), _ = open_pairs({"effects": [], "silent": [entry]}, (), dataset)
    assert isinstance(pair.effect, JointBacklash) and pair.effect.by == "moves"


def test_two_flexible_terms_of_one_kind_are_two_effects() -> None:
    """Terms of two links that bend with gravity are alike in all but the number of the link; a question has the columns of both, each once."""
    dataset = make_scene("vs060", "tracker", seed=2, poses_per_plane=30).dataset
    terms = (UnattributedLink(4, GRAVITY), UnattributedLink(6, GRAVITY))
    made = calibrate(dataset, effects=terms)
    cell = Workcell.of(dataset.robot, dataset.sensor, (), made, repeatability=2e-5, same_campaign=True)
    found = draw_candidates(cell, 5, np.random.default_rng(0))
    asked = [e for e in JointHarmonic.candidates(dataset) if e.target == {"joint": 2, "order": 1}]
    pair = Pair(asked[0].with_coefficients(asked[0].natural_sizes), None)
    what = open_questions(cell, [pair], dataset, cell.dataset(found.q, found.plane), 1.0)
    (question,) = what.questions
    columns = np.r_[question.rest, question.own]
    tilts = dataset.robot.n_joints  # of the axes, which are no columns of a question
    assert len(np.unique(columns)) == len(columns) == len(what.start) - tilts


def test_a_question_on_play_is_asked_of_an_arm_without_effects() -> None:
    """Planned poses have directions of approach although the calibration has no effect that needs them: one in question may."""
    dataset = make_scene("vs060", "tracker", seed=2, poses_per_plane=30).dataset
    sides = np.random.default_rng(1).choice([-1, 1], (dataset.n_poses, 6))
    dataset = replace(
        dataset, poses=dataset.poses.assign(**{f"approach{j + 1}": sides[:, j] for j in range(6)})
    )
    made = calibrate(dataset)
    cell = Workcell.of(dataset.robot, dataset.sensor, (), made, repeatability=2e-5, same_campaign=True)
    found = draw_candidates(cell, 5, np.random.default_rng(0))
    both = [e for e in JointBacklash.candidates(dataset) if e.target["joint"] == 2]
    (play,) = [e for e in both if isinstance(e, JointBacklash) and e.by == "approach"]
    pair = Pair(play.with_coefficients(play.natural_sizes), None)
    what = open_questions(cell, [pair], dataset, cell.dataset(found.q, found.plane), 1.0)
    assert np.isfinite(what.rows).all() and what.rows[:, :, what.questions[0].own].any()
