# The paper takes its numbers and figures from the results, and its text from paper/. If a config does not ask for a part of the results, the
# section of that part is left out, and the title says that the paper is a draft.
from study.paper.reported import TABLES as REPORTED_TABLES

PAPER = ROOT / "paper"
PAPER_NUMBERS = {
    "headline": f"{HEADLINE}/numbers.json"
}  # {part: JSON file with the numbers that the text quotes}
PAPER_FIGURES = {  # {path by which the text includes the figure: file}
    "headline/errors.svg": f"{HEADLINE}/figures/errors.svg",
    "headline/parameters.svg": f"{HEADLINE}/figures/parameters_proposed.svg",
    "headline/singular_values.svg": f"{HEADLINE}/figures/singular_values_{FIRST_CASE.name}.svg",
    "headline/scene.svg": f"{HEADLINE}/figures/scene.svg",
}
if f"{HEADLINE}/figures/workspace.svg" in SCENE_FIGURES:
    PAPER_FIGURES["headline/workspace.svg"] = f"{HEADLINE}/figures/workspace.svg"
    PAPER_FIGURES["headline/correlation.svg"] = f"{HEADLINE}/figures/correlation.svg"

PAPER_NUMBERS["linear_estimate"] = f"{HEADLINE}/linear_estimate.json"
PAPER_NUMBERS["other_arms"] = f"{HEADLINE}/identifiability/other_arms.json"
if "sequential" in config:
    PAPER_NUMBERS["sequential"] = f"{SEQUENTIAL_DIR}/numbers.json"
    PAPER_FIGURES["sequential/sequential.svg"] = f"{SEQUENTIAL_DIR}/figures/sequential.svg"

PAPER_NUMBERS["worked_example"] = f"{EXAMPLE}/numbers.json"
PAPER_FIGURES["worked_example/worked_example.svg"] = f"{EXAMPLE}/figures/worked_example.svg"
if AXES:
    PAPER_NUMBERS["sweeps"] = f"{SWEEP_DIR}/numbers.json"
    for walls in WALLS:
        PAPER_FIGURES[f"sweeps/overview_{walls}.svg"] = f"{SWEEP_DIR}/figures/overview_{walls}.svg"
if PUBLISHED_CURVES:
    PAPER_NUMBERS["published_curves"] = f"{PUBLISHED_CURVES_DIR}/numbers.json"
    for name in PUBLISHED_CURVES_PICTURES:
        PAPER_FIGURES[f"published_curves/{name}.svg"] = f"{PUBLISHED_CURVES_DIR}/figures/{name}.svg"

# Studies that take hours, or need files that others published, have small committed summaries; their figures are drawn from these.
TRIALS_SUMMARIES = PAPER / "summaries/blind_trials"
if (TRIALS_SUMMARIES / "numbers.json").exists():
    PAPER_NUMBERS["blind_trials"] = local(TRIALS_SUMMARIES / "numbers.json")
    for name in TRIALS_FIGURES:
        PAPER_FIGURES[f"blind_trials/{name}.svg"] = f"{RESULTS}/paper/blind_trials/{name}.svg"

TRIALS_REPORTED = [TRIALS_SUMMARIES / f"{name}.csv" for name in REPORTED_TABLES]
TRIALS_REPORTED = TRIALS_REPORTED if "blind_trials" in PAPER_NUMBERS else []

STRATIFIED_SUMMARIES = PAPER / "summaries/stratified"
STRATIFIED_REPORTED = []
if (STRATIFIED_SUMMARIES / "numbers.json").exists():
    PAPER_NUMBERS["stratified"] = local(STRATIFIED_SUMMARIES / "numbers.json")
    # table.csv is the last sealed exam, and exams/1.csv, exams/2.csv ... are those before it. The table of a further exam replaces table.csv, which
    # is first moved to the end of exams/.
    STRATIFIED_REPORTED = [
        STRATIFIED_SUMMARIES / "table.csv",
        *sorted((STRATIFIED_SUMMARIES / "exams").glob("*.csv"), key=lambda path: int(path.stem)),
    ]

EXAM_RECORDS = [path.with_suffix(".json") for path in STRATIFIED_REPORTED[1:]]

LEANING_SUMMARY = PAPER / "summaries/leaning_walls/numbers.json"
if LEANING_SUMMARY.exists():
    PAPER_NUMBERS["leaning_walls"] = local(LEANING_SUMMARY)

STARTS_SUMMARY = PAPER / "summaries/starts/numbers.json"
if STARTS_SUMMARY.exists():
    PAPER_NUMBERS["starts"] = local(STARTS_SUMMARY)

TRACKED_SUMMARY = PAPER / "summaries/tracked_trials/numbers.json"
if TRACKED_SUMMARY.exists():
    PAPER_NUMBERS["tracked_trials"] = local(TRACKED_SUMMARY)

REAL_ARM_SUMMARY = PAPER / "summaries/real_arm_trials/numbers.json"
if REAL_ARM_SUMMARY.exists():
    PAPER_NUMBERS["real_arm_trials"] = local(REAL_ARM_SUMMARY)

BENCHMARK_SUMMARY = PAPER / "summaries/benchmark/numbers.json"
BENCHMARK_TABLE = ROOT / "benchmarks/diagnosis/results.csv"
if BENCHMARK_SUMMARY.exists():
    PAPER_NUMBERS["benchmark"] = local(BENCHMARK_SUMMARY)

MEASURED_SUMMARIES = PAPER / "summaries/measured"
if (MEASURED_SUMMARIES / "numbers.json").exists():
    PAPER_NUMBERS["measured"] = local(MEASURED_SUMMARIES / "numbers.json")
    for name in MEASURED_FIGURES:
        PAPER_FIGURES[f"measured/{name}.svg"] = f"{RESULTS}/paper/measured/{name}.svg"

if (MEASURED_SUMMARIES / "rivals.json").exists():
    PAPER_NUMBERS["measured_rivals"] = local(MEASURED_SUMMARIES / "rivals.json")

if (MEASURED_SUMMARIES / "published.json").exists():
    PAPER_NUMBERS["measured_published"] = local(MEASURED_SUMMARIES / "published.json")

SENSITIVITY_SUMMARIES = PAPER / "summaries/sensitivity"
if (SENSITIVITY_SUMMARIES / "numbers.json").exists():
    PAPER_NUMBERS["sensitivity"] = local(SENSITIVITY_SUMMARIES / "numbers.json")
    PAPER_FIGURES["sensitivity/sensitivity.svg"] = f"{RESULTS}/paper/sensitivity/sensitivity.svg"

CONFIDENCE_SUMMARIES = PAPER / "summaries/confidence"
if (CONFIDENCE_SUMMARIES / "numbers.json").exists():
    PAPER_NUMBERS["confidence"] = local(CONFIDENCE_SUMMARIES / "numbers.json")
    PAPER_FIGURES["confidence/reliability.svg"] = f"{RESULTS}/paper/confidence/reliability.svg"

PLANNING_SUMMARIES = PAPER / "summaries/planning"
if all((PLANNING_SUMMARIES / name).exists() for name in ("numbers.json", "separation.json")):
    PAPER_NUMBERS["planning"] = local(PLANNING_SUMMARIES / "numbers.json")
    PAPER_NUMBERS["separation"] = local(PLANNING_SUMMARIES / "separation.json")

EDGES_SUMMARIES = PAPER / "summaries/edges"
if (EDGES_SUMMARIES / "numbers.json").exists():
    PAPER_NUMBERS["edges"] = local(EDGES_SUMMARIES / "numbers.json")
    PAPER_FIGURES["edges/edges.svg"] = f"{RESULTS}/paper/edges/edges.svg"

PROCESSORS_SUMMARY = PAPER / "summaries/processors/numbers.json"
if PROCESSORS_SUMMARY.exists():
    PAPER_NUMBERS["processors"] = local(PROCESSORS_SUMMARY)


use rule draw_measured as draw_committed_measured with:
    input:
        errors=local(MEASURED_SUMMARIES / "errors.csv"),
        gears=local(MEASURED_SUMMARIES / "gears.csv"),
        modules=modules("study.plots.measured", "study.common.tables"),
    output:
        **{
            f"{name}_{suffix}": f"{RESULTS}/paper/measured/{name}.{suffix}"
            for name in MEASURED_FIGURES
            for suffix in ("png", "svg")
        },
    log:
        f"{RESULTS}/logs/paper/draw_measured.log",
    message:
        "Drawing the measured robots from their committed summaries"


use rule draw_blind_trials as draw_committed_blind_trials with:
    input:
        summaries=[local(TRIALS_SUMMARIES / f"{name}.csv") for name in TRIALS_TABLES],
        modules=modules("study.plots.blind_trials", "study.common.tables"),
    output:
        **{
            f"{name}_{suffix}": f"{RESULTS}/paper/blind_trials/{name}.{suffix}"
            for name in TRIALS_FIGURES
            for suffix in ("png", "svg")
        },
    log:
        f"{RESULTS}/logs/paper/draw_blind_trials.log",
    message:
        "Drawing the blind trials from their committed summaries"


use rule draw_sensitivity as draw_committed_sensitivity with:
    input:
        table=local(SENSITIVITY_SUMMARIES / "settings.csv"),
        modules=modules("study.plots.sensitivity", "study.common.tables"),
    output:
        **{suffix: f"{RESULTS}/paper/sensitivity/sensitivity.{suffix}" for suffix in ("png", "svg")},
    log:
        f"{RESULTS}/logs/paper/draw_sensitivity.log",
    message:
        "Drawing the sensitivity to settings from its committed summary"


use rule draw_confidence as draw_committed_confidence with:
    input:
        reliability=local(CONFIDENCE_SUMMARIES / "reliability.csv"),
        modules=modules("study.plots.confidence", "study.common.tables"),
    output:
        **{suffix: f"{RESULTS}/paper/confidence/reliability.{suffix}" for suffix in ("png", "svg")},
    log:
        f"{RESULTS}/logs/paper/draw_confidence.log",
    message:
        "Drawing how often answers are right from the committed summary"


use rule draw_edges as draw_committed_edges with:
    input:
        edges=local(EDGES_SUMMARIES / "edges.csv"),
        summary=local(EDGES_SUMMARIES / "summary.csv"),
        modules=modules("study.plots.edges", "study.common.tables"),
    output:
        **{suffix: f"{RESULTS}/paper/edges/edges.{suffix}" for suffix in ("png", "svg")},
    log:
        f"{RESULTS}/logs/paper/draw_edges.log",
    message:
        "Drawing the diagnoses of spoiled data from their committed summaries"


rule draw_sweep_overview:
    input:
        summaries=expand(f"{SWEEP_DIR}/{{sweep}}/summary.csv", sweep=AXES),
        published=resource("published_curves.csv"),
        modules=modules("study.plots.sweep_overview", "study.common.tables"),
    output:
        **figure(
            f"{SWEEP_DIR}/figures/overview_{{walls}}",
            "figure_sweep_overview",
            "Sweeps",
            sweep="all",
            walls="{walls}",
            shows="mean position error of all sweeps",
        ),
    log:
        f"{RESULTS}/logs/draw_sweep_overview/{{walls}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        axes={
            name: {key: axis[key] for key in ("label", "scale", "published") if key in axis}
            for name, axis in AXES.items()
        },
        walls=lambda w: w.walls,
    message:
        "Drawing all sweeps at a glance, walls {wildcards.walls}"
    script:
        "../scripts/draw_sweep_overview.py"


rule gather_numbers:
    input:
        parts=list(PAPER_NUMBERS.values()),
        scene=local(config_path(STUDIES["headline"]["scene"])),
        tilted=local(ROOT / "configs/scenes/paper_tilted.yaml"),
        headline=resource("published_headline.csv"),
        planes=resource("published_plane_errors.csv"),
        curves=resource("published_curves.csv"),
        claims=resource("published_claims.csv"),
        followup=resource("published_followup.csv"),
        published_measured=resource("published_measured.csv"),
        judged=resource("judged_claims.csv"),
        trials=[local(path) for path in TRIALS_REPORTED],
        stratified=[local(path) for path in STRATIFIED_REPORTED],
        exams=[local(path) for path in EXAM_RECORDS],
        ratios=local(STRATIFIED_SUMMARIES / "ratios.csv") if STRATIFIED_REPORTED else [],
        conditions=local(STRATIFIED_SUMMARIES / "conditions.csv") if STRATIFIED_REPORTED else [],
        confidence=local(STRATIFIED_SUMMARIES / "confidence.csv") if STRATIFIED_REPORTED else [],
        separation=local(PLANNING_SUMMARIES / "separation.csv") if "separation" in PAPER_NUMBERS else [],
        correlation=f"{HEADLINE}/correlation.csv" if "headline/correlation.svg" in PAPER_FIGURES else [],
        workspace=f"{HEADLINE}/workspace.csv" if "headline/workspace.svg" in PAPER_FIGURES else [],
        rivals=local(BENCHMARK_TABLE) if "benchmark" in PAPER_NUMBERS else [],
        modules=modules(
            "study.paper.numbers",
            "study.paper.committed",
            "study.paper.measured_published",
            "study.paper.measured_rivals",
            "study.paper.parts",
            "study.paper.trials",
            "study.common.tables",
        ),
    output:
        f"{RESULTS}/paper/numbers.json",
    log:
        f"{RESULTS}/logs/paper/gather_numbers.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        parts=PAPER_NUMBERS,
        trials=[path.stem for path in TRIALS_REPORTED],
        seeds=STUDIES["headline"]["seeds"],
        draft=config.get("paper", {}).get("draft", False),
    message:
        "Gathering the paper's numbers"
    script:
        "../scripts/gather_numbers.py"


rule paper:
    input:
        numbers=rules.gather_numbers.output[0],
        text=[local(path) for path in sorted(PAPER.rglob("*")) if path.suffix in (".typ", ".bib")],
        figures=list(PAPER_FIGURES.values()),
        modules=modules("study.paper.typeset"),
    output:
        report(
            f"{RESULTS}/paper.pdf",
            caption="../report/paper.rst",
            category="Paper",
            labels={"shows": "the paper"},
        ),
    log:
        f"{RESULTS}/logs/paper/paper.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        text=lambda w, input: os.path.commonpath(input.text),
        figures=PAPER_FIGURES,
    message:
        "Typesetting the paper"
    script:
        "../scripts/build_paper.py"
