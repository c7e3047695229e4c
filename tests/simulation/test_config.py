"""A scene's config: what is misspelt or contradicts itself is refused, by name."""

import copy

import pytest

from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.errors import InvalidInput
from scalar.simulation.config import complete_config, load_config, scene_schema
from tests.simulation.conftest import CONFIGS, SCENES

PAPER = load_yaml(CONFIGS / "scenes" / "paper.yaml")


def with_value(path, value):
    """Return the paper's config with `value` at `path`, a tuple of keys."""
    config = copy.deepcopy(PAPER)
    place = config
    for key in path[:-1]:
        place = place.setdefault(key, {}) if isinstance(place, dict) else place[key]
    place[path[-1]] = value
    return config


def refusal(config):
    """Return the message with which a config is refused."""
    with pytest.raises(InvalidInput) as caught:
        complete_config(config, base_dir=CONFIGS / "scenes", file="scene.yaml")
    return str(caught.value)


@pytest.mark.parametrize("name", (*SCENES, "injected"))
def test_committed_scenes_are_sound(name):
    """Every committed scene loads, complete, and completing it again changes nothing."""
    config = load_config(CONFIGS / "scenes" / f"{name}.yaml")
    assert complete_config(config) == config


MISSPELT = [
    (("nois",), "nois", "noise"),
    (("sensor", "fan_half_angle"), "sensor.fan_half_angle", "fan_half_angle_deg"),
    (("noise", "range_noise_std_mm"), "noise.range_noise_std_mm", "range_noise_std_m"),
    (("initial_model", "length_std"), "initial_model.length_std", "length_std_m"),
    (("planes", 1, "distance"), "planes[1].distance", "distance_m"),
    (("plane_guess", "tilt"), "plane_guess.tilt", "tilt_deg"),
    (("body", "clearence_m"), "body.clearence_m", "clearance_m"),
]


@pytest.mark.parametrize(("path", "place", "meant"), MISSPELT, ids=[row[1] for row in MISSPELT])
def test_a_misspelt_key_is_named(path, place, meant):
    """A key that the schema does not know is refused with its place and the key that was meant."""
    message = refusal(with_value(path, 1.0))
    assert f"scene.yaml, {place}: unknown key {path[-1]!r}; did you mean {meant!r}?" in message


def test_a_misspelt_key_of_an_inline_robot_is_named():
    """The robot block may stand in the config itself, and is checked there as well."""
    robot = load_yaml(CONFIGS / "robots" / "vs060.yaml")
    assert complete_config(PAPER | {"robot": robot})["robot"] == robot
    robot["joints"][2]["thetta"] = 0.0
    assert "robot.joints[2].thetta: unknown key" in refusal(PAPER | {"robot": robot})


CONTRADICTIONS = [
    (("sensor", "range_m"), [0.5, 0.1], "sensor.range_m"),
    (("sensor", "rays"), 50, "sensor.rays"),
    (("planes", 1, "name"), "floor", "planes[1].name"),
    (("planes", 0, "normal"), [0, 0, 0], "planes[0].normal"),
    (("poses_per_plane",), {"floor": 3}, "poses_per_plane"),
    (("initial_model", "exact"), ["a_7"], "initial_model.exact"),
    (("true_robot_errors",), {"length_std_m": 1e-3}, "initial_model"),
    (("seed",), -1, "seed"),
    (("seed",), "one", "seed"),
    (("noise", "range_noise_std_m"), -1e-4, "noise.range_noise_std_m"),
    (("noise", "range_noise_std_m"), float("nan"), "noise.range_noise_std_m"),
    (("planes",), [], "planes"),
]


@pytest.mark.parametrize(("path", "value", "place"), CONTRADICTIONS, ids=lambda x: str(x))
def test_nonsense_is_refused_where_it_stands(path, value, place):
    """A value that cannot be meant is refused with the path of its key."""
    assert f"scene.yaml, {place}: " in refusal(with_value(path, value))


def test_all_faults_are_found_at_once():
    """Two misspelt keys give two lines."""
    config = with_value(("nois",), 1) | {"sede": 1}
    assert len(refusal(config).splitlines()) == 2


def test_a_missing_key_is_named():
    """A config without seed is refused, and the message says seed."""
    config = copy.deepcopy(PAPER)
    del config["seed"]
    assert "seed: missing; add it" in refusal(config)


@pytest.mark.parametrize("value", [5.0, "five", None, [5]])
def test_a_number_of_poses_that_is_none_is_refused_in_plain_words(value):
    """The message says the key, what was found and what is wanted, and nothing of schemas."""
    message = refusal(PAPER | {"poses_per_plane": value})
    assert "poses_per_plane: " in message
    assert "write one number, or one for each plane by name" in message
    assert "schema" not in message and "valid" not in message
    if value is not None:
        assert str(value) in message


def test_one_of_the_numbers_of_poses_is_named_by_its_plane():
    """If each plane has its own number of poses, a faulty one is named by its place, and not the whole list."""
    message = refusal(PAPER | {"poses_per_plane": {"floor": 0}})
    assert "poses_per_plane.floor: 0 is less than 1; write a whole number at least 1" in message


def test_the_robot_path_starts_at_the_config(tmp_path):
    """A relative robot path starts at the config's folder; one that leads nowhere is refused by name."""
    config = copy.deepcopy(PAPER)
    config["robot"] = "arm.yaml"
    dump_yaml(config, tmp_path / "scene.yaml")
    with pytest.raises(InvalidInput, match=r"arm\.yaml"):
        load_config(tmp_path / "scene.yaml")
    dump_yaml(load_yaml(CONFIGS / "robots" / "vs060.yaml"), tmp_path / "arm.yaml")
    assert load_config(tmp_path / "scene.yaml")["robot"]["name"] == "vs060"


def test_every_key_of_the_schema_is_closed():
    """No object in the schema lets unknown keys through, so that none can be misspelt in silence."""

    def objects(schema):
        if isinstance(schema, dict):
            if schema.get("type") == "object":
                yield schema
            for key, value in schema.items():
                if key != "if":  # a condition lets nothing through
                    yield from objects(value)
        elif isinstance(schema, list):
            for value in schema:
                yield from objects(value)

    for schema in objects(scene_schema()):
        if "allOf" in schema:  # one closed alternative for each value of a key
            (choice,) = schema["required"]
            handled = [branch["if"]["properties"][choice]["const"] for branch in schema["allOf"]]
            assert handled == schema["properties"][choice]["enum"]
            assert all(branch["then"]["$ref"].startswith("#/$defs/") for branch in schema["allOf"])
        else:
            assert "additionalProperties" in schema
            assert schema["additionalProperties"] is not True


@pytest.mark.parametrize(
    ("config", "place", "old", "new"),
    [
        (PAPER | {"planted": [{"effect": "joint_scale"}]}, "planted", "planted", "injected"),
        (
            PAPER | {"injected": [{"effect": "thermal_drift", "course": "warm_up"}]},
            "injected[0].course",
            "course",
            "profile",
        ),
    ],
)
def test_a_former_key_is_refused_with_the_present_one(config, place, old, new):
    """A scene of an older version is not read silently without its effects: the message names the new key."""
    message = refusal(config)
    assert place in message and f"the key {old!r} is now called {new!r}" in message


@pytest.mark.parametrize(
    "path, value",
    [
        (("seed",), 1.0),
        (("poses_per_plane",), 5.0),
        (("sensor", "points_per_scan"), 64.0),
        (("planes", 0, "normal"), [0, 0, int("9" * 390)]),
    ],
)
def test_an_integer_has_no_point_and_no_number_has_hundreds_of_digits(path, value):
    """A whole number with a point where an integer is asked, and one too large to compute with, are refused by key."""
    assert path[0] in refusal(with_value(path, value))
