# Do planned poses match twice as many random ones? A target of its own, some minutes; its summary is committed:
#   snakemake planning --cores 2
#   cp results/planning/{summary.csv,numbers.json} paper/summaries/planning/
PLANNING = config.get("planning") or {
    "scene": STUDIES["headline"]["scene"],
    "seeds": 30,
    "seeds_per_job": 15,
    "poses": [30, 60],
    "pool_per_plane": 400,
}
PLANNING_DIR = f"{RESULTS}/planning"


localrules:
    planning,


rule compare_plans:
    input:
        scene=local(named(PLANNING["scene"])),
        robot=lambda w: robot_of_scene(named(PLANNING["scene"])),
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


rule planning:
    input:
        rules.collect_plans.output,
