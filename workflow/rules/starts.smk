# What the start of a fit contributes to its convergence, and what its parameters do: both methods from the start of either, over the sweeps of the
# initial guesses. Not part of the default target: `snakemake starts` takes some minutes. The summaries are committed:
#   cp results/starts/summaries/* paper/summaries/starts/
STARTS_DIR = f"{RESULTS}/starts/summaries"
STARTS_AXES = [sweep for sweep in ("plane_tilt", "initial_model") if sweep in AXES]


localrules:
    starts,


rule compare_starts:
    input:
        scenes=[local(scene) for scene in WALLS.values()],
        robots=sorted({robot for scene in WALLS.values() for robot in robot_of_scene(scene)}),
        plans=expand(f"{SWEEP_DIR}/plans/{{walls}}/{{batch}}.npz", walls=WALLS, batch=SWEEP_BATCHES),
        modules=modules("study.sweeps.starts", "study.common.tables"),
    output:
        table=f"{RESULTS}/starts/starts.csv",
        numbers=f"{STARTS_DIR}/numbers.json",
    log:
        f"{RESULTS}/logs/starts/compare.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        walls=list(WALLS),
        seeds={batch: batch_seeds(batch) for batch in SWEEP_BATCHES},
        cases={
            sweep: {name: case.overrides for name, case in SWEEP_CASES[sweep].items()}
            for sweep in STARTS_AXES
        },
        values={sweep: values_on_axis(AXES[sweep], SWEEP_CASES[sweep]) for sweep in STARTS_AXES},
    message:
        "Starting both methods from the start of either"
    script:
        "../scripts/compare_starts.py"


rule starts:
    input:
        rules.compare_starts.output if STARTS_AXES else [],
