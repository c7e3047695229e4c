# The tracked trials: arms before a tracker or with a probe are simulated without the estimator's formulas, diagnosed blind and scored. They are not
# part of the default target: `snakemake tracked_trials` runs them, and goes on with a run that was stopped. The summaries are committed:
#   cp results/tracked_trials/summaries/* paper/summaries/tracked_trials/
from study.tracked_trials.design import load_tracked
from study.tracked_trials.workcell import WORKCELL

try:
    TRACKED_CONFIG = config_path(config.get("tracked_trials", "configs/tracked_trials.yaml"))
    TRACKED = load_tracked(TRACKED_CONFIG)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None
TRACKED_DIR = f"{RESULTS}/tracked_trials"
TRACKED_TABLES = ["table", "errors", "causes", "nulls", "faults"]


wildcard_constraints:
    sensor="tracker|targets|probe",


localrules:
    tracked_trials,


rule run_tracked_trials:
    input:
        robots=[local(ROOT / "configs/robots" / f"{name}.yaml") for name in TRACKED.content["robots"]],
        workcell=local(WORKCELL),
        modules=modules("study.tracked_trials.run", "study.common.tables"),
    output:
        f"{TRACKED_DIR}/sets/{{sensor}}/{{numbers}}.csv",
    log:
        f"{RESULTS}/logs/tracked_trials/{{sensor}}/{{numbers}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(TRACKED_CONFIG),
        # The design without the numbers of sets: an edit of it runs all jobs again, but a larger number of sets adds jobs only.
        design=repr({k: v for k, v in TRACKED.content.items() if k != "sets"}),
    message:
        "Tracked trials: {wildcards.sensor}, sets {wildcards.numbers}"
    script:
        "../scripts/run_tracked_trials.py"


rule summarise_tracked_trials:
    input:
        sets=[f"{TRACKED_DIR}/sets/{sensor}/{job}.csv" for sensor, job in TRACKED.jobs()],
        modules=modules("study.tracked_trials.summaries", "study.common.tables"),
    output:
        **{name: f"{TRACKED_DIR}/summaries/{name}.csv" for name in TRACKED_TABLES},
        numbers=f"{TRACKED_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/tracked_trials/summarise.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        design=TRACKED.content,
    message:
        "Scoring the tracked trials"
    script:
        "../scripts/summarise_tracked_trials.py"


rule tracked_trials:
    input:
        rules.summarise_tracked_trials.output,
