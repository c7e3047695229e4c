# Is it better to calibrate scanner and arm at once, or one after the other? The same data are fitted in every order. A config without the key
# `sequential` omits this comparison.
SEQUENTIAL = config.get("sequential") or {**STUDIES["headline"], "seeds_per_job": 1, "alternate": []}
SEQUENTIAL_CASES = checked_grids({"sequential": SEQUENTIAL})["sequential"]
SEQUENTIAL_DIR = f"{RESULTS}/sequential"
SEQUENTIAL_TABLES = expand(f"{SEQUENTIAL_DIR}/{{name}}", name=["errors.csv", "summary.csv", "numbers.json"])
SEQUENTIAL_FIGURES = expand(f"{SEQUENTIAL_DIR}/figures/sequential.{{suffix}}", suffix=["png", "svg"])
if "sequential" not in config:
    SEQUENTIAL_TABLES, SEQUENTIAL_FIGURES = [], []

for name in SEQUENTIAL["alternate"]:
    if name not in SEQUENTIAL_CASES:
        raise WorkflowError(f"sequential: alternate names {name}, which is no case of {SEQUENTIAL['grid']}")


rule compare_sequential:
    input:
        scene=local(config_path(SEQUENTIAL["scene"])),
        robot=lambda w: robot_of_scene(config_path(SEQUENTIAL["scene"])),
        modules=modules("study.sequential.compare", "study.common.tables"),
    output:
        f"{SEQUENTIAL_DIR}/batches/{{batch}}.csv",
    log:
        f"{RESULTS}/logs/compare_sequential/{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/compare_sequential/{{batch}}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    params:
        cases={name: case.overrides for name, case in SEQUENTIAL_CASES.items()},
        alternate=SEQUENTIAL["alternate"],
        seeds=lambda w: batch_seeds(w.batch),
    message:
        "Calibrating at once and one after the other, {wildcards.batch}"
    script:
        "../scripts/compare_sequential.py"


rule collect_sequential:
    input:
        tables=expand(
            rules.compare_sequential.output[0],
            batch=batch_names(config["first_seed"], SEQUENTIAL["seeds"], SEQUENTIAL["seeds_per_job"]),
        ),
        modules=modules("study.sequential.summary", "study.common.tables"),
    output:
        errors=f"{SEQUENTIAL_DIR}/errors.csv",
        summary=report(
            f"{SEQUENTIAL_DIR}/summary.csv",
            caption="../report/sequential_summary.rst",
            category="At once or in sequence",
            labels={"shows": "errors over the seeds"},
        ),
        numbers=f"{SEQUENTIAL_DIR}/numbers.json",
    log:
        f"{RESULTS}/logs/collect_sequential.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Collecting the errors of calibrations at once and one after the other"
    script:
        "../scripts/collect_sequential.py"


rule draw_sequential:
    input:
        errors=rules.collect_sequential.output.errors,
        summary=rules.collect_sequential.output.summary,
        modules=modules("study.plots.sequential", "study.common.tables"),
    output:
        **figure(
            f"{SEQUENTIAL_DIR}/figures/sequential",
            "figure_sequential",
            "At once or in sequence",
            shows="errors by passes and by cases",
        ),
    log:
        f"{RESULTS}/logs/draw_sequential.log",
    conda:
        ENVIRONMENT
    threads: 1
    script:
        "../scripts/draw_sequential.py"
