"""Comparisons that the paper makes in words hold in the committed summaries, so that a new summary does not leave a sentence behind."""

import csv
import json
from pathlib import Path
from typing import Any

import yaml
from study.blind_trials.score import NOISES

ROOT = Path(__file__).parents[3]
SUMMARIES = ROOT / "paper/summaries"


def read(name: str) -> Any:
    """Return a summary, as its file has it."""
    path = SUMMARIES / name
    if path.suffix == ".csv":
        with path.open(encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))
    return json.loads(path.read_text(encoding="utf-8"))


def test_worse_initial_models_are_told_apart_by_upright_walls_alone():
    """The clipped reading fails clearly more often than the proposed method with upright walls, and about as often with leaning ones."""
    found = read("starts/numbers.json")["initial_model"]
    bad = {
        (walls, method): sum(found[walls][method]["own"][key] for key in ("failed", "lost"))
        for walls in ("upright", "tilted")
        for method in ("proposed", "baseline-clip")
    }
    assert bad["upright", "baseline-clip"] > 1.5 * bad["upright", "proposed"]
    assert bad["tilted", "baseline-clip"] < 1.5 * bad["tilted", "proposed"]
    assert all(found[walls]["proposed"]["own"]["lost"] == 0 for walls in ("upright", "tilted"))
    for walls in ("upright", "tilted"):  # "that start does not help the clipped reading"
        own, other = (found[walls]["baseline-clip"][start] for start in ("own", "other"))
        assert own["failed"] + own["lost"] <= other["failed"] + other["lost"]


def test_the_sealed_exam_has_no_jitter():
    """No set of the sealed exam has a jitter of the joints or an error common to a scan (stratified)."""
    design = yaml.safe_load((ROOT / "configs/blind_trials_stratified.yaml").read_text(encoding="utf-8"))
    design |= yaml.safe_load((ROOT / "configs/blind_trials_sealed.yaml").read_text(encoding="utf-8"))
    assert not set(NOISES) & {*design["effects"], *design["causes"], *design["shapes"]}


def test_geometry_alone_does_little_for_the_iiwa():
    """In the three campaigns of the iiwa geometry predicts held-out poses about as well as base and tool (measured)."""
    sets = {
        name: found
        for name, found in read("measured/numbers.json")["sets"].items()
        if name.startswith("iiwa")
    }
    assert len(sets) == 3
    for found in sets.values():
        base, geometry = (found["models"][name]["held_out_rms_mm"] for name in ("base_and_tool", "geometry"))
        assert abs(geometry / base - 1) < 0.05


def test_errors_are_several_times_what_the_arms_repeat():
    """Where an arm came back to its poses, the errors are more than three times the scatter, also after the correction (measured)."""
    for found in read("measured/numbers.json")["sets"].values():
        if found.get("repeated_poses"):
            errors = [model["held_out_rms_mm"] for model in found["models"].values()] + [
                found["unseen"]["after_rms_mm"]
            ]
            assert min(errors) > 3 * found["repeated_poses"]["scatter_mm"]


def test_only_the_most_stray_points_hide_a_gear():
    """Structure is found and not named in one set, with a gear and the most stray points that are answered; no gear is named wrongly (edges)."""
    rows = read("edges/edges.csv")
    answered = [
        float(row["value"]) for row in rows if row["axis"] == "outliers" and row["answer"] != "refused"
    ]
    unnamed = [row for row in rows if row["verdict"] == "unattributed"]
    assert [(row["injected"], row["axis"], float(row["value"])) for row in unnamed] == [
        ("gear", "outliers", max(answered))
    ]
    assert all(row["answer"] in ("right", "refused") for row in rows if row not in unnamed)


def of_all(rows: Any) -> dict[str, dict[str, str]]:
    """Return the rates of all sets of an exam by their names, with `sets` and `count` as they are printed."""
    return {
        row["rate"]: row | {key: f"{int(row[key]):,}" for key in ("sets", "count")}
        for row in rows
        if row["row"] == "all"
    }


def test_readme_and_documentation_say_how_the_last_exam_ended():
    """README and the page on trials have the counts of the last sealed exam, and that page its 95 % intervals."""
    found = of_all(read("stratified/table.csv"))
    last, sets = {rate: row["count"] for rate, row in found.items()}, found["clean"]["sets"]
    readme, trials = (
        " ".join((ROOT / name).read_text(encoding="utf-8").split())
        for name in ("README.md", "docs/trials.md")
    )
    assert (
        f"{last['clean']} of {sets} answers are without a fault, {last['wrong_sure']} have a wrong name with a confidence of 0.8 or more, "
        f"and {last['worse']} corrections make predictions worse by more than 5 %"
    ) in readme
    told = [
        f"{last[rate]} ({100 * float(found[rate]['low']):.{digits}f} to {100 * float(found[rate]['high']):.{digits}f} %)"
        for rate, digits in (("clean", 0), ("wrong", 1), ("wrong_sure", 2), ("worse", 1))
    ]
    assert f"| [scanners](#scanners) | {sets} sets | {' | '.join(told)} |" in trials


def test_the_table_of_the_last_exam_is_that_of_the_summary():
    """Each row of the table of scanners has the counts of the summary; sets with ideal and with imperfect scanners are added where both have rows."""
    page = (ROOT / "docs/trials.md").read_text(encoding="utf-8")
    counts: dict[tuple[str, str], int] = {}
    for row in read("stratified/table.csv"):
        name = row["row"].removesuffix(", ideal").removesuffix(", imperfect")
        for key, value in ((row["rate"], row["count"]), (f"sets of {row['rate']}", row["sets"])):
            counts[name, key] = counts.get((name, key), 0) + int(value)
    for name, words in {
        "no effect": "no effect",
        "one effect": "one effect",
        "3 to 5 effects": "3 to 5 effects, 120 or 300 poses",
        "60 poses": "60 poses, none to 5 effects",
        "unknown cause": "a cause that no effect describes",
        "shape also tried": "a cause whose shape is tried as a flexible term, or late triggering",
        "all": "all",
    }.items():
        told = [
            counts[name, key] for key in ("sets of clean", "clean", "missed", "wrong", "wrong_sure", "worse")
        ]
        assert f"| {words} | {' | '.join(f'{number:,}' for number in told)} |" in page


def test_the_confidences_of_the_last_exam_are_those_of_the_summary():
    """The page has the answers of the last exam by their confidence: how many, how many are right, and what was stated."""
    page = (ROOT / "docs/trials.md").read_text(encoding="utf-8")
    rows = [row for row in read("stratified/confidence.csv") if row["of"] == "effect"]
    words = ("less than 0.5 (with others that the data do not distinguish)", "0.5 to 0.8", "0.8 to 0.9", "0.9 to 0.95", "0.95 or more")  # fmt: skip
    for name, row in zip(words, rows, strict=True):
        answers, right = int(row["answers"]), int(row["right"])
        told = f"{answers:,} | {right:,} | {right / answers:.2f} | {float(row['mean_stated']):.2f}"
        assert f"| {name} | {told} |" in page, name
    answers, right = (
        sum(int(row[key]) for row in rows if float(row["from"]) >= 0.8) for key in ("answers", "right")
    )
    assert f"of {answers:,} effects with 0.8 or more {right:,} are right" in page


def test_the_balance_of_trackers_and_of_real_arms_is_that_of_the_summaries():
    """The first table of the page has the counts of the last exams of trackers and probes and of real arms' effects, with their 95 % intervals."""
    page = (ROOT / "docs/trials.md").read_text(encoding="utf-8")

    def told(row: dict[str, str], digits: int, of: str = "") -> str:
        low, high = (f"{100 * float(row[key]):.{digits}f}".removesuffix(".0") for key in ("low", "high"))
        return f"{row['count']}{of} ({low} to {high} %)"

    tracked = {
        row["rate"]: row
        for row in read("tracked_trials/table.csv")
        if row["sensor"] == row["stated"] == "all"
    }
    real = {
        row["rate"]: row
        for row in read("real_arm_trials/table.csv")
        if row["instrument"] == row["effect"] == row["size"] == row["company"] == "all"
    }
    cells = [
        told(tracked["clean"], 0),
        *(told(tracked[rate], 1) for rate in ("wrong", "wrong_sure", "worse")),
    ]
    assert f"| {tracked['clean']['sets']} sets | {' | '.join(cells)} |" in page
    cells = [told(real["right"], 0, f" of {real['right']['sets']} effects right")]
    cells += [told(real[rate], 1) for rate in ("wrong", "wrong_sure", "worse")]
    assert f"| {real['wrong']['sets']} sets | {' | '.join(cells)} |" in page


def test_the_table_of_all_exams_is_that_of_the_summaries():
    """The page on the exams has a row for each sealed exam, the last one included, with the commit of the diagnosis and the counts of its summary."""
    page = (ROOT / "docs/exams.md").read_text(encoding="utf-8")
    earlier = len(list((SUMMARIES / "stratified/exams").glob("*.csv")))
    assert earlier >= 28
    names = [*(f"exams/{i}.csv" for i in range(1, earlier + 1)), "table.csv"]
    records = [*(f"exams/{i}.json" for i in range(1, earlier + 1)), "numbers.json"]
    for number, (name, record) in enumerate(zip(names, records, strict=True), start=1):
        commit = read(f"stratified/{record}")["design"]["sealed_after"][:8]
        found = of_all(read(f"stratified/{name}"))
        clean, wrong, sure, worse = (
            found[rate]["count"] for rate in ("clean", "wrong", "wrong_sure", "worse")
        )
        row = f"| {number} | {commit} | {found['clean']['sets']} | {clean} | {wrong} ({sure}) | {worse} |"
        assert row in page, row


def test_the_table_of_halves_is_that_of_the_summary():
    """The page on measured arms has a row for each campaign whose halves were diagnosed, with the errors of the summary to two places."""
    page = (ROOT / "docs/measured_arms.md").read_text(encoding="utf-8")
    table = page[
        page.index("## Halves of campaigns") : page.index("In ten halves the stated error")
    ].splitlines()
    sets = read("measured/rivals.json")["sets"]
    rows = [line for line in table if line.startswith("| `")]
    assert len(rows) == len(sets)
    for name, found in sets.items():
        told = [
            ", ".join(f"{half[key]:.2f}" for half in found["halves"])
            for key in ("geometry_mm", "diagnosis_mm", "diagnosis_within_mm", "stated_mm")
        ]
        assert f"| `{name}` | {' | '.join(told)} |" in rows
    assert (
        sum(
            1.05 * half["stated_mm"] < half["diagnosis_within_mm"]
            for found in sets.values()
            for half in found["halves"]
        )
        == 10
    )


def test_causes_without_a_name_are_corrected_where_their_shape_is_tried():
    """Of the causes whose shape no flexible term has, most are reported and most not corrected; of the others most are corrected (conclusions)."""
    ratios = {
        row["row"]: float(row["value"])
        for row in read("stratified/ratios.csv")
        if row["ratio"] == "after_over_before" and row["quantile"] == "0.5"
    }
    assert ratios["unknown cause"] == 1.0 and ratios["shape also tried"] < 0.9
    shares = {
        row["row"]: float(row["share"])
        for row in read("stratified/table.csv")
        if row["rate"] == "unattributed"
    }
    assert min(shares["unknown cause"], shares["shape also tried"]) > 0.5
