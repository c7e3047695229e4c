# The real-arm trials: what campaigns with real arms record and suffer is injected by the simulator at three sizes, alone and beside two others, and
# diagnosed blind. They are not part of the default target: `snakemake real_arm_trials` runs them, and goes on with a run that was stopped. The
# summaries are committed:
#   cp results/real_arm_trials/summaries/* paper/summaries/real_arm_trials/
from study.real_arm_trials.design import load_real_arm

try:
    REAL_ARM_CONFIG = config_path(config.get("real_arm_trials", "configs/real_arm_trials.yaml"))
    REAL_ARM = load_real_arm(REAL_ARM_CONFIG)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None
REAL_ARM_DIR = f"{RESULTS}/real_arm_trials"
REAL_ARM_TABLES = ["table", "errors", "faults"]


wildcard_constraints:
    instrument="tracker|rail|scanner",


localrules:
    real_arm_trials,


rule run_real_arm_trials:
    input:
        scenes=lambda w: [
            path
            for robot in REAL_ARM.content["instruments"][w.instrument]["robots"]
            for path in files_of_scene(ROOT / f"configs/scenes/{robot}.yaml")
        ],
        modules=modules("study.real_arm_trials.run", "study.common.tables"),
    output:
        f"{REAL_ARM_DIR}/sets/{{instrument}}/{{numbers}}.csv",
    log:
        f"{RESULTS}/logs/real_arm_trials/{{instrument}}/{{numbers}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(REAL_ARM_CONFIG),
        root=local(ROOT),
        # What the sets of an instrument depend on: an edit of it runs its jobs again, but more repetitions add jobs only.
        design=lambda w: repr(
            {k: v for k, v in REAL_ARM.content.items() if k != "instruments"}
            | {k: v for k, v in REAL_ARM.content["instruments"][w.instrument].items() if k != "repetitions"}
        ),
    message:
        "Real-arm trials: {wildcards.instrument}, sets {wildcards.numbers}"
    script:
        "../scripts/run_real_arm_trials.py"


rule summarise_real_arm_trials:
    input:
        sets=[f"{REAL_ARM_DIR}/sets/{instrument}/{job}.csv" for instrument, job in REAL_ARM.jobs()],
        modules=modules("study.real_arm_trials.summaries", "study.common.tables"),
    output:
        **{name: f"{REAL_ARM_DIR}/summaries/{name}.csv" for name in REAL_ARM_TABLES},
        numbers=f"{REAL_ARM_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/real_arm_trials/summarise.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        design=REAL_ARM.content,
    message:
        "Scoring the real-arm trials"
    script:
        "../scripts/summarise_real_arm_trials.py"


rule real_arm_trials:
    input:
        rules.summarise_real_arm_trials.output,
