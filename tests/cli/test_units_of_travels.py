"""Travels of a joint that slides: millimetres that are probably metres are asked about, and lengths are written in the unit of the travels."""

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import read_dataset
from scalar.data.table_units import units_to_write
from scalar.estimation.result import Calibration
from tests.cli.running import run
from tests.rail_and_arm import RailAndArm, poses

TRAVELS_AND_ANGLES = ["pose", *(f"q{i}" for i in range(1, 8))]


@pytest.fixture(scope="module")
def rail(tmp_path_factory):
    """Return a folder with a calibration of an arm on a rail, and a program of five poses in m and rad."""
    folder = tmp_path_factory.mktemp("rail")
    rng = np.random.default_rng(4)
    RailAndArm.drawn(rng).dataset(poses(30, rng), 1e-5, rng).write(folder / "d")
    data = read_dataset(folder / "d")
    Calibration.nominal(data).save(folder / "c.json")
    program = pd.DataFrame(data.q[:5], columns=TRAVELS_AND_ANGLES[1:])
    program.insert(0, "pose", range(5))
    program.to_csv(folder / "p.csv", index=False)
    return folder


@pytest.mark.parametrize("command", ["correct", "predict"])
def test_metres_under_the_option_mm_are_asked_about(rail, command):
    """A travel of at most 1.6 under `--units mm` is 1.6 mm; the command says so, and how to state metres."""
    said = run(
        command, rail / "c.json", rail / "p.csv", "-o", rail / "o.csv", "--force", "--units", "mm"
    ).output
    assert "check the units: joint 1 slides, and its largest travel in this table is " in said
    assert "name the column q1_m" in said
    renamed = pd.read_csv(rail / "p.csv").rename(columns={"q1": "q1_mm"})
    renamed.to_csv(rail / "p_mm.csv", index=False)
    said = run(command, rail / "c.json", rail / "p_mm.csv", "-o", rail / "o.csv", "--force").output
    assert "rename the column q1_mm to q1_m" in said


@pytest.mark.parametrize("command", ["correct", "predict"])
def test_travels_whose_unit_is_clear_are_not_asked_about(rail, command):
    """Metres without the option, a column q1_m beside it, and travels of hundreds of millimetres raise no doubt; a column q1_m stays in metres."""
    table = pd.read_csv(rail / "p.csv")
    table.rename(columns={"q1": "q1_m"}).to_csv(rail / "m.csv", index=False)
    table.assign(q1=table["q1"] * 1e3).to_csv(rail / "mm.csv", index=False)
    places = []
    for name, options in (("p", []), ("m", ["--units", "mm"]), ("mm", ["--units", "mm"])):
        result = run(
            command, rail / "c.json", rail / f"{name}.csv", "-o", rail / "o.csv", "--force", *options
        )
        assert result.exit_code == 0 and "check the units" not in result.output, result.output
        written = pd.read_csv(rail / "o.csv")
        at = ["q1_mm" if options else "q1"] if command == "correct" else ["x_mm" if options else "x"]
        places.append(written[at[0]].to_numpy() * (1e-3 if options else 1.0))
    np.testing.assert_allclose(places[1], places[0], atol=1e-9)
    np.testing.assert_allclose(places[2], places[0], atol=1e-9)


def test_degrees_with_travels_in_metres_are_written_with_metres(rail):
    """With `--units deg` a travel without a unit is read in metres, so the corrected travels are in metres too."""
    turned = pd.read_csv(rail / "p.csv")
    turned[TRAVELS_AND_ANGLES[2:]] *= 180 / np.pi
    turned.to_csv(rail / "deg.csv", index=False)
    result = run(
        "correct", rail / "c.json", rail / "deg.csv", "-o", rail / "o.csv", "--force", "--units", "deg"
    )
    assert result.exit_code == 0, result.output
    columns = set(pd.read_csv(rail / "o.csv").columns)
    assert {"q1", "q2_deg", "position_error"} <= columns
    assert not {"q1_mm", "position_error_mm"} & columns


@pytest.mark.parametrize(
    ("text", "columns", "pair"),
    [
        ("deg", ["q1", "q2"], ("m", "deg")),
        ("deg", ["q1_m", "q2"], ("m", "deg")),
        ("deg", ["q1_mm", "q2"], ("mm", "deg")),
        ("deg,mm", ["q1", "q2"], ("mm", "deg")),
        (None, ["q1_mm", "q2_deg"], ("mm", "deg")),
        (None, ["q1", "q2_deg"], ("m", "deg")),
    ],
)
def test_the_unit_of_a_travel_decides(text, columns, pair):
    """Degrees go with millimetres only where no travel is read in metres."""
    written = units_to_write(text, columns, [0])
    assert (written.length, written.angle) == pair
