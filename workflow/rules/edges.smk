# At which degree of a fault the diagnosis fails. The faults are stray points, wrong labels, missing poses, a wrong statement of the noise and poor
# initial guesses. The study is not part of the default target. Nearly all of its time is spent on diagnoses, 48 for each seed, of 3 to 8 s: about ten
# minutes of one core for two seeds. One job diagnoses all faults of a seed, since the dataset without a fault is the same for all of them. The
# summaries may be committed:
#   snakemake edges --cores 2
#   cp results/edges/summaries/* paper/summaries/edges/
from study.edges.axes import AXES as AXES_OF_EDGES

EDGES = config.get("edges") or {"scene": STUDIES["headline"]["scene"], "seeds": 2, "seeds_per_job": 1}
EDGES_DIR = f"{RESULTS}/edges"
EDGE_VALUES = {
    axis: list(EDGES.get("values", {}).get(axis, AXES_OF_EDGES[axis].values)) for axis in AXES_OF_EDGES
}


localrules:
    edges,


rule run_edges:
    input:
        scene=local(config_path(EDGES["scene"])),
        robot=lambda w: robot_of_scene(config_path(EDGES["scene"])),
        modules=modules("study.edges.run", "study.common.tables"),
    output:
        f"{EDGES_DIR}/batches/{{batch}}.csv",
    log:
        f"{RESULTS}/logs/edges/{{batch}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        degrees=EDGE_VALUES,
        seeds=lambda w: batch_seeds(w.batch),
    message:
        "Diagnosing spoiled data: {wildcards.batch}"
    script:
        "../scripts/run_edges.py"


rule collect_edges:
    input:
        tables=expand(
            rules.run_edges.output[0],
            batch=batch_names(config["first_seed"], EDGES["seeds"], EDGES["seeds_per_job"]),
        ),
        modules=modules("study.edges.summary", "study.common.tables"),
    output:
        edges=f"{EDGES_DIR}/summaries/edges.csv",
        summary=report(
            f"{EDGES_DIR}/summaries/summary.csv",
            caption="../report/edges.rst",
            category="Spoiled data",
            labels={"shows": "errors and answers"},
        ),
        numbers=f"{EDGES_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/edges/collect.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Collecting the diagnoses of spoiled data"
    script:
        "../scripts/collect_edges.py"


rule draw_edges:
    input:
        edges=rules.collect_edges.output.edges,
        summary=rules.collect_edges.output.summary,
        modules=modules("study.plots.edges", "study.common.tables"),
    output:
        **figure(f"{EDGES_DIR}/figures/edges", "figure_edges", "Spoiled data", shows="curves"),
    log:
        f"{RESULTS}/logs/edges/draw.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Drawing the diagnoses of spoiled data"
    script:
        "../scripts/draw_edges.py"


rule edges:
    input:
        rules.collect_edges.output,
        rules.draw_edges.output,
