# The blind trials: effects are injected into simulated workcells, the datasets are diagnosed without knowledge of them, and the answers are scored.
# They are not part of the default target: `snakemake blind_trials` runs them, and goes on with a run that was stopped. The summaries are small
# enough to be committed:
#   cp results/blind_trials/summaries/* paper/summaries/blind_trials/
from study.blind_trials.cases import load_study
from study.blind_trials.stratified_design import load_design

try:
    TRIALS_CONFIG = config_path(config.get("blind_trials", "configs/blind_trials.yaml"))
    TRIALS = load_study(TRIALS_CONFIG)
    STRATIFIED_CONFIG = config_path(
        config.get("blind_trials_stratified", "configs/blind_trials_stratified.yaml")
    )
    STRATIFIED = load_design(STRATIFIED_CONFIG)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None
TRIALS_DIR = f"{RESULTS}/blind_trials"
TRIALS_TABLES = [
    "confusion",
    "power",
    "thresholds",
    "by_workcell",
    "by_scene",
    "nulls",
    "pairs",
    "unknown",
    "errors",
    "reliability",
    "unobservable",
    "wrong_answers",
]
TRIALS_FIGURES = ["confusion", "power", "errors", "reliability"]


wildcard_constraints:
    workcell="|".join(TRIALS.workcells),
    repetitions=r"\d+-\d+",
    numbers=r"\d+-\d+",


localrules:
    blind_trials,
    blind_trials_stratified,


rule run_blind_trials:
    input:
        scene=lambda w: files_of_scene(ROOT / TRIALS.workcells[w.workcell]["scene"]),
        modules=modules("study.blind_trials.run", "study.common.tables"),
    output:
        f"{TRIALS_DIR}/sets/{{case}}/{{workcell}}/{{repetitions}}.csv",
    log:
        f"{RESULTS}/logs/blind_trials/{{case}}/{{workcell}}/{{repetitions}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(TRIALS_CONFIG),
        root=local(ROOT),
        # The sets of the job, so that an edit of the config runs again only the jobs whose sets it changes.
        sets=lambda w: repr(
            (
                TRIALS.scene,
                TRIALS.workcells[w.workcell],
                list(TRIALS.sets(w.case, w.workcell, w.repetitions)),
            )
        ),
    message:
        "Blind trials: {wildcards.case} in {wildcards.workcell}, repetitions {wildcards.repetitions}"
    script:
        "../scripts/run_blind_trials.py"


rule summarise_blind_trials:
    input:
        sets=[f"{TRIALS_DIR}/sets/{'/'.join(job)}.csv" for job in TRIALS.jobs()],
        modules=modules(
            "study.blind_trials.summaries",
            "study.blind_trials.benefit",
            "study.blind_trials.numbers",
            "study.common.tables",
        ),
    output:
        **{name: f"{TRIALS_DIR}/summaries/{name}.csv" for name in TRIALS_TABLES},
        numbers=f"{TRIALS_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/blind_trials/summarise.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(TRIALS_CONFIG),
    message:
        "Scoring the blind trials"
    script:
        "../scripts/summarise_blind_trials.py"


rule draw_blind_trials:
    input:
        summaries=[f"{TRIALS_DIR}/summaries/{name}.csv" for name in TRIALS_TABLES],
        modules=modules("study.plots.blind_trials", "study.common.tables"),
    output:
        **{
            f"{name}_{suffix}": path
            for name in TRIALS_FIGURES
            for suffix, path in figure(
                f"{TRIALS_DIR}/figures/{name}", f"figure_blind_trials_{name}", "Blind trials", shows=name
            ).items()
        },
    log:
        f"{RESULTS}/logs/blind_trials/draw.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        figures=TRIALS_FIGURES,
    message:
        "Drawing the blind trials"
    script:
        "../scripts/draw_blind_trials.py"


rule blind_trials:
    input:
        rules.summarise_blind_trials.output,
        rules.draw_blind_trials.output,


# The stratified trials cross scanners, surfaces, effects, numbers of poses and robots so that every pair of their levels occurs. A run that was
# stopped goes on with the jobs that are left.
#   snakemake blind_trials_stratified --cores 2 --config blind_trials_stratified=MY_DESIGN.yaml
# The paper reports the sealed ones, whose seed was drawn after the code was frozen; their summaries are committed:
#   snakemake blind_trials_stratified --cores 2 --config blind_trials_stratified=configs/blind_trials_sealed.yaml
#   cp results/blind_trials_stratified/summaries/* paper/summaries/stratified/
STRATIFIED_DIR = f"{RESULTS}/blind_trials_stratified"
STRATIFIED_TABLES = ["table", "ratios", "confidence", "conditions"]
if STRATIFIED.outer_split:
    STRATIFIED_TABLES.append("outer_split")


rule run_stratified_trials:
    input:
        scenes=[
            path
            for robot in STRATIFIED.content["robots"].values()
            for path in files_of_scene(ROOT / robot["scene"])
        ],
        modules=modules("study.blind_trials.stratified_run", "study.common.tables"),
    output:
        f"{STRATIFIED_DIR}/sets/{{numbers}}.csv",
    log:
        f"{RESULTS}/logs/blind_trials_stratified/{{numbers}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(STRATIFIED_CONFIG),
        root=local(ROOT),
        # The design without the number of sets: an edit of it runs all jobs again, but a larger number of sets adds jobs only.
        design=repr({k: v for k, v in STRATIFIED.content.items() if k != "sets"}),
    message:
        "Stratified blind trials: sets {wildcards.numbers}"
    script:
        "../scripts/run_stratified_trials.py"


rule summarise_stratified_trials:
    input:
        sets=[f"{STRATIFIED_DIR}/sets/{job}.csv" for job in STRATIFIED.jobs()],
        modules=modules(
            "study.blind_trials.stratified_summaries",
            "study.blind_trials.outer_split_summary",
            "study.common.tables",
        ),
    output:
        **{name: f"{STRATIFIED_DIR}/summaries/{name}.csv" for name in STRATIFIED_TABLES},
        numbers=f"{STRATIFIED_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/blind_trials_stratified/summarise.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        design=STRATIFIED.content,
    message:
        "Scoring the stratified blind trials"
    script:
        "../scripts/summarise_stratified_trials.py"


rule blind_trials_stratified:
    input:
        rules.summarise_stratified_trials.output,
