"""Numbers and paths of the command line that are none: not a number, infinite, out of bounds, empty."""

import pytest

from tests.cli.running import run

NOT_FINITE = ("nan", "inf", "1e400")


@pytest.mark.parametrize(
    ("command", "option", "others"),
    [
        ("plan ur10e", "--accuracy", ("0", "-1")),
        ("plan ur10e", "--noise", ("0", "1e9")),
        ("plan ur10e", "--repeatability", ("-1", "1e300")),
        ("plan ur10e", "--fan", ("0", "-5", "90", "1e308")),
        ("plan ur10e", "--incidence", ("0", "-5", "91")),
        ("compare a.json b.json", "--alpha", ("0", "0.6")),
        ("import-bag cell a.bag", "--still", ("0", "-1")),
        ("import-bag cell a.bag", "--settled", ("-1",)),
        ("import-bag cell a.bag", "--least", ("0", "-1")),
    ],
)
def test_a_number_that_is_none_is_refused_by_its_option(command, option, others, tmp_path):
    """The message names the option, and nothing is written; ``nan`` had been within all bounds, and a plan had expected errors of NaN."""
    for number in (*NOT_FINITE, *others):
        result = run(*command.split(), "-o", tmp_path / "out", option, number)
        assert result.exit_code == 2, (number, result.output)
        assert option in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("number", ["nan", "0.1,inf", "nan,0.4", "0.1,nan"])
def test_a_range_that_has_no_end_is_refused(number, tmp_path):
    """Both distances of a scanner's range are finite."""
    result = run("plan", "ur10e", "-o", tmp_path / "out", "--no-collisions", "--range", number)
    assert result.exit_code == 2 and "--range" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", ["", "a\0b"])
@pytest.mark.parametrize(
    "command",
    [
        ["validate", "{}"],
        ["calibrate", "cell", "-o", "{}"],
        ["predict", "{}", "joints.csv", "-o", "out.csv"],
        ["predict", "a.json", "{}", "-o", "out.csv"],
        ["init", "{}", "--robot", "ur10e", "--sensor", "tracker"],
        ["import", "{}", "a.csv", "-o", "out"],
    ],
)
def test_an_empty_path_is_no_path(command, path, tmp_path, monkeypatch):
    """``-o "$OUT"`` with a variable that is not set had written to the working directory."""
    monkeypatch.chdir(tmp_path)
    result = run(*(path if word == "{}" else word for word in command))
    assert result.exit_code == 2, result.output
    assert "an empty path" in result.stderr
    assert list(tmp_path.iterdir()) == []
