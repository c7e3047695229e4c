"""Payloads in newtons, pounds or grams are asked about where the arm's rated payload, or what any arm carries, shows it."""

import numpy as np
import pytest

from scalar.data.record_units import units_suspected
from scalar.robots import arm_names, largest_payload, read_arm, resembling

GRAVITY, GRAM = 9.81, 1000.0  # a kilogram as a number of newtons and of grams


@pytest.mark.parametrize("mass", [2.0, 6.0])
@pytest.mark.parametrize(("factor", "word"), [(GRAVITY, "newtons"), (GRAM, "grams")])
def test_a_load_in_another_unit_is_asked_about(mass, factor, word):
    """A third of the rated payload is enough to notice newtons on a 6 kg arm; the clause names the likelier unit."""
    (clause,) = units_suspected({"payload": np.array([0.0, mass * factor])}, rated=6.0)
    assert clause.startswith("payload") and f"are these {word}" in clause and "in 1 of 2 poses" in clause


@pytest.mark.parametrize(("mass", "rated"), [(6.0, 6.0), (11.0, 6.0), (900.0, None)])
def test_a_usual_load_is_not(mass, rated):
    """Nor is an overload, or a heavy load on an arm of which nothing is known."""
    assert units_suspected({"payload": np.array([0.0, mass])}, rated) == []


def test_without_a_rated_payload_only_the_impossible_is_asked_about():
    """More than any arm carries may be grams or newtons."""
    (clause,) = units_suspected({"payload": np.array([2500.0])})
    assert "grams, or newtons" in clause


@pytest.mark.parametrize(
    ("name", "payload"),
    [
        ("kuka_kr6_r900_sixx", 6),
        ("KR 6 R900", 6),
        ("cell 3, UR10e", 10),
        ("kr6", None),
        ("arm", None),
        ("--", None),
    ],
)
def test_the_rated_payload_is_that_of_an_arm_whose_name_resembles(name, payload):
    """A name that says nothing of the model has none."""
    assert largest_payload(name) == payload


@pytest.mark.parametrize("name", arm_names())
def test_a_payload_of_the_library_stands_in_the_name(name):
    """The number is part of the arm's name, which resembles itself alone."""
    arm = read_arm(name)
    assert [other.name for other in resembling(name)] == [name]
    assert arm.payload is None or f"{arm.payload:g}" in "".join(c for c in arm.model + name if c.isalnum())


@pytest.mark.parametrize(
    "name",
    [
        "my IRB 1600",
        "IRB1200 cell 4",
        "Yaskawa GP88",
        "motoman gp250",
        "GP70L",
        "M-10iA/7L",
        "UR10",
        "kuka",
        "abb irb",
        "tx2_90xl",
    ],
)
def test_another_model_and_a_maker_alone_resemble_nothing(name):
    """A model's name that begins like another one's is not that of the other, and a maker builds many arms."""
    assert not {
        "abb_irb120",
        "yaskawa_gp8",
        "yaskawa_gp25",
        "yaskawa_gp7",
        "fanuc_m10ia",
        "ur10e",
        "kuka_kr16_2",
        "staubli_tx2_90",
    } & {arm.name for arm in resembling(name)}


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("my UR5e", ["ur5e"]),
        ("KR 6 R900", ["kuka_kr6_r900_2", "kuka_kr6_r900_sixx"]),
        ("Yaskawa GP-8, left", ["yaskawa_gp8"]),
    ],
)
def test_a_model_is_found_in_a_longer_or_a_shorter_name(name, found):
    """The words of one name stand in the other."""
    assert [arm.name for arm in resembling(name)] == found
