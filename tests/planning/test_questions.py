"""The questions that a diagnosis leaves open are read from its file as it judged them."""

from __future__ import annotations

from scalar.data.io.atomic import plain
from scalar.diagnosis.observability import Unobservable
from scalar.effects.joint_backlash import JointBacklash
from scalar.planning.questions import open_pairs
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
