# The spoiled set-ups: one thing about the description of a sound simulated campaign is made wrong, and what `scalar calibrate` says is scored. They
# are not part of the default target: `snakemake spoiled_setups` runs them, and goes on with a run that was stopped. The summaries are committed:
#   cp results/spoiled_setups/summaries/* paper/summaries/spoiled_setups/
from study.spoiled_setups.design import load_spoiled

try:
    SPOILED_CONFIG = config_path(config.get("spoiled_setups", "configs/spoiled_setups.yaml"))
    SPOILED = load_spoiled(SPOILED_CONFIG)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None
SPOILED_DIR = f"{RESULTS}/spoiled_setups"


localrules:
    spoiled_setups,


rule run_spoiled_setups:
    input:
        arms=[local(path) for path in sorted((ROOT / "scalar/robots/arms").glob("*.yaml"))],
        modules=modules("study.spoiled_setups.run", "study.common.tables"),
    output:
        f"{SPOILED_DIR}/sets/{{numbers}}.csv",
    log:
        f"{RESULTS}/logs/spoiled_setups/{{numbers}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(SPOILED_CONFIG),
        # The design without the number of sets: an edit of it runs all jobs again, but a larger number of sets adds jobs only.
        design=repr({k: v for k, v in SPOILED.content.items() if k != "sets"}),
    message:
        "Spoiled set-ups {wildcards.numbers}"
    script:
        "../scripts/run_spoiled_setups.py"


rule summarise_spoiled_setups:
    input:
        sets=[f"{SPOILED_DIR}/sets/{job}.csv" for job in SPOILED.jobs()],
        modules=modules("study.spoiled_setups.summaries", "study.common.tables"),
    output:
        **{name: f"{SPOILED_DIR}/summaries/{name}.csv" for name in ("table", "faults")},
        numbers=f"{SPOILED_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/spoiled_setups/summarise.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        design=SPOILED.content,
    message:
        "Scoring the spoiled set-ups"
    script:
        "../scripts/summarise_spoiled_setups.py"


rule spoiled_setups:
    input:
        rules.summarise_spoiled_setups.output,
