# The published curves are explained again: with walls that lean by up to three degrees, with roots of negative numbers passed on as NaN, and with
# the published run that the config leaves out. This is not part of the default target and takes some ten minutes of processor time. The summaries
# are committed:
#   cp results/leaning_walls/summaries/* paper/summaries/leaning_walls/
from study.published_curves.leaning_walls import LEANS_DEG

LEANING = config.get("leaning_walls") or {"seeds": 12, "leans_deg": list(LEANS_DEG)}
LEANING_DIR = f"{RESULTS}/leaning_walls"
LEANING_SUMMARIES = f"{LEANING_DIR}/summaries"


wildcard_constraints:
    lean=r"\d+(\.\d+)?",


localrules:
    leaning_walls,


rule fit_leaning_walls:
    input:
        scene=local(PUBLISHED_CURVES_SCENE),
        robot=lambda w: robot_of_scene(PUBLISHED_CURVES_SCENE),
        published=resource("published_curves.csv"),
        modules=modules("study.published_curves.leaning_walls", "study.common.tables"),
    output:
        f"{LEANING_DIR}/fits/lean-{{lean}}.csv",
    log:
        f"{RESULTS}/logs/leaning_walls/{{lean}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        lean_deg=lambda w: float(w.lean),
        seeds=list(range(config["first_seed"], config["first_seed"] + LEANING["seeds"])),
        options=PUBLISHED_CURVES_OPTIONS,
    message:
        "Fitting the published runs with walls that lean by {wildcards.lean} degrees"
    script:
        "../scripts/fit_leaning_walls.py"


rule weigh_leaning_walls:
    input:
        scene=local(PUBLISHED_CURVES_SCENE),
        robot=lambda w: robot_of_scene(PUBLISHED_CURVES_SCENE),
        published=resource("published_curves.csv"),
        fits=expand(rules.fit_leaning_walls.output[0], lean=[f"{lean:g}" for lean in LEANING["leans_deg"]]),
        modules=modules("study.published_curves.leaning_support", "study.common.tables"),
    output:
        table=f"{LEANING_SUMMARIES}/behind.csv",
        numbers=f"{LEANING_SUMMARIES}/numbers.json",
    log:
        f"{RESULTS}/logs/leaning_walls/weigh.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        options=PUBLISHED_CURVES_OPTIONS,
    message:
        "Weighing the readings of the baseline's square root with leaning walls"
    script:
        "../scripts/weigh_leaning_walls.py"


rule leaning_walls:
    input:
        rules.weigh_leaning_walls.output if PUBLISHED_CURVES else [],
