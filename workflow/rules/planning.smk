# Two questions about planned poses: are calibrations with them as accurate as with twice as many random ones, and do further planned poses separate
# causes that a diagnosis could not distinguish? The study is not part of the default target and takes some minutes. The summaries are committed:
#   snakemake planning --cores 2
#   cp results/planning/{summary.csv,numbers.json,separation.csv,separation.json} paper/summaries/planning/
PLANNING = config.get("planning") or {
    "scene": STUDIES["headline"]["scene"],
    "seeds": 30,
    "seeds_per_job": 15,
    "poses": [30, 60],
    "pool_per_plane": 400,
}
PLANNING_DIR = f"{RESULTS}/planning"
SEPARATION = PLANNING.get("separation") or {
    "cases": ["joint_compliance", "base_compliance", "range_offset"],
    "repetitions": 1,
    "first_poses_per_plane": 20,
    "pool_per_plane": 400,
    "further_poses": 20,
}
SEPARATION_JOBS = [
    (case, workcell, f"{k:03d}-{k:03d}")
    for case in SEPARATION["cases"]
    if case in TRIALS.cases
    for workcell in TRIALS.workcells
    if TRIALS.cases[case].possible(workcell)
    for k in range(1, SEPARATION["repetitions"] + 1)
]


localrules:
    planning,


rule compare_plans:
    input:
        scene=local(config_path(PLANNING["scene"])),
        robot=lambda w: robot_of_scene(config_path(PLANNING["scene"])),
        modules=modules("study.planning.compare", "study.common.tables"),
    output:
        f"{PLANNING_DIR}/batches/{{batch}}.csv",
    log:
        f"{RESULTS}/logs/compare_plans/{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/compare_plans/{{batch}}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    params:
        sizes=PLANNING["poses"],
        pool_per_plane=PLANNING["pool_per_plane"],
        seeds=lambda w: batch_seeds(w.batch),
    message:
        "Calibrating planned and random poses, {wildcards.batch}"
    script:
        "../scripts/compare_plans.py"


rule collect_plans:
    input:
        tables=expand(
            rules.compare_plans.output[0],
            batch=batch_names(config["first_seed"], PLANNING["seeds"], PLANNING["seeds_per_job"]),
        ),
        modules=modules("study.planning.summary", "study.common.tables"),
    output:
        errors=f"{PLANNING_DIR}/errors.csv",
        summary=report(
            f"{PLANNING_DIR}/summary.csv",
            caption="../report/planning_summary.rst",
            category="Planned poses",
            labels={"shows": "errors over the seeds"},
        ),
        numbers=f"{PLANNING_DIR}/numbers.json",
    log:
        f"{RESULTS}/logs/collect_plans.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Collecting planned and random poses"
    script:
        "../scripts/collect_plans.py"


rule separate_causes:
    input:
        scene=lambda w: files_of_scene(ROOT / TRIALS.workcells[w.workcell]["scene"]),
        modules=modules("study.planning.separate", "study.common.tables"),
    output:
        f"{PLANNING_DIR}/separation/{{case}}/{{workcell}}/{{repetitions}}.csv",
    log:
        f"{RESULTS}/logs/separate_causes/{{case}}/{{workcell}}/{{repetitions}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(TRIALS_CONFIG),
        root=local(ROOT),
        sizes={
            "first": SEPARATION["first_poses_per_plane"],
            "pool": SEPARATION["pool_per_plane"],
            "further": SEPARATION["further_poses"],
        },
    message:
        "Separating confounded causes by further poses: {wildcards.case} in {wildcards.workcell}"
    script:
        "../scripts/separate_causes.py"


rule collect_separations:
    input:
        tables=[
            f"{PLANNING_DIR}/separation/{case}/{workcell}/{repetitions}.csv"
            for case, workcell, repetitions in SEPARATION_JOBS
        ],
        modules=modules("study.planning.separation_summary", "study.common.tables"),
    output:
        pairs=f"{PLANNING_DIR}/separation.csv",
        numbers=f"{PLANNING_DIR}/separation.json",
    log:
        f"{RESULTS}/logs/collect_separations.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        further=SEPARATION["further_poses"],
    message:
        "Counting the confounded causes that further poses separate"
    script:
        "../scripts/collect_separations.py"


rule planning:
    input:
        rules.collect_plans.output,
        rules.collect_separations.output,
