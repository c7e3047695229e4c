# The closed loop: plant, diagnose blind, score. A target of its own, `snakemake closed_loop`, and about an hour on
# two cores; a run that was stopped goes on where it was. Its summaries are small enough to be committed:
#   cp results/closed_loop/summaries/* paper/summaries/closed_loop/
from study.blind_trials.cases import load_study

try:
    LOOP_CONFIG = ROOT / config.get("closed_loop", "configs/closed_loop.yaml")
    LOOP = load_study(LOOP_CONFIG)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None
LOOP_DIR = f"{RESULTS}/closed_loop"
LOOP_TABLES = [
    "confusion",
    "power",
    "thresholds",
    "by_cell",
    "nulls",
    "pairs",
    "unknown",
    "errors",
    "reliability",
    "silent",
    "wrong_answers",
]
LOOP_FIGURES = ["confusion", "power", "errors", "reliability"]


wildcard_constraints:
    cell="|".join(LOOP.cells),
    repetitions=r"\d+-\d+",


localrules:
    closed_loop,


def loop_scene(wildcards):
    """Return the scene of a cell and its robot's file."""
    scene = ROOT / LOOP.cells[wildcards.cell]["scene"]
    robot = load_yaml(scene).get("robot")
    return [
        local(path.resolve()) for path in [scene, *([scene.parent / robot] if isinstance(robot, str) else [])]
    ]


rule run_closed_loop:
    input:
        scene=loop_scene,
        modules=modules("study.blind_trials.run", "study.common.tables"),
    output:
        f"{LOOP_DIR}/sets/{{case}}/{{cell}}/{{repetitions}}.csv",
    log:
        f"{RESULTS}/logs/closed_loop/{{case}}/{{cell}}/{{repetitions}}.log",
    threads: 1
    params:
        config=local(LOOP_CONFIG),
        root=local(ROOT),
        # So that an edit of the config runs again what it changes, and nothing else.
        sets=lambda w: repr((LOOP.scene, LOOP.cells[w.cell], list(LOOP.sets(w.case, w.cell, w.repetitions)))),
    message:
        "Closed loop: {wildcards.case} in {wildcards.cell}, repetitions {wildcards.repetitions}"
    script:
        "../scripts/run_closed_loop.py"


rule summarise_closed_loop:
    input:
        sets=[f"{LOOP_DIR}/sets/{'/'.join(job)}.csv" for job in LOOP.jobs()],
        modules=modules(
            "study.blind_trials.summaries",
            "study.blind_trials.benefit",
            "study.blind_trials.numbers",
            "study.common.tables",
        ),
    output:
        **{name: f"{LOOP_DIR}/summaries/{name}.csv" for name in LOOP_TABLES},
        numbers=f"{LOOP_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/closed_loop/summarise.log",
    threads: 1
    params:
        config=local(LOOP_CONFIG),
    message:
        "Scoring the closed loop"
    script:
        "../scripts/summarise_closed_loop.py"


rule draw_closed_loop:
    input:
        summaries=[f"{LOOP_DIR}/summaries/{name}.csv" for name in LOOP_TABLES],
        modules=modules("study.plots.blind_trials", "study.common.tables"),
    output:
        **{
            f"{name}_{suffix}": path
            for name in LOOP_FIGURES
            for suffix, path in figure(
                f"{LOOP_DIR}/figures/{name}", f"figure_closed_loop_{name}", "Closed loop", shows=name
            ).items()
        },
    log:
        f"{RESULTS}/logs/closed_loop/draw.log",
    threads: 1
    params:
        figures=LOOP_FIGURES,
    message:
        "Drawing the closed loop"
    script:
        "../scripts/draw_closed_loop.py"


rule closed_loop:
    input:
        rules.summarise_closed_loop.output,
        rules.draw_closed_loop.output,
