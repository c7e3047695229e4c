# The sweeps: errors over the values of one key of the scene, with a figure for each sweep and kind of walls. A config without the key `sweeps` omits
# them.
from study.sweeps.cases import in_groups, most_poses, refuse_cases_off_the_axis, values_on_axis

SWEEPS = config.get("sweeps") or {
    "axes": {},
    "walls": {},
    "methods": [],
    "seeds": 1,
    "seeds_per_job": 1,
    "cases_per_job": 1,
}
AXES = SWEEPS["axes"]
WALLS = {walls: config_path(scene) for walls, scene in SWEEPS["walls"].items()}  # {kind of walls: its scene}
SWEEP_CASES = checked_grids(AXES)
SWEEP_GROUPS = {sweep: in_groups(cases, SWEEPS["cases_per_job"]) for sweep, cases in SWEEP_CASES.items()}
SWEEP_BATCHES = batch_names(config["first_seed"], SWEEPS["seeds"], SWEEPS["seeds_per_job"])
SWEEP_DIR = f"{RESULTS}/sweeps"
SWEEP_FIGURES = expand(
    f"{SWEEP_DIR}/{{sweep}}/figures/{{walls}}.{{suffix}}", sweep=AXES, walls=WALLS, suffix=["png", "svg"]
)

SWEEP_NUMBERS = [f"{SWEEP_DIR}/numbers.json"] if AXES else []

try:
    refuse_cases_off_the_axis(AXES, SWEEP_CASES)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None


wildcard_constraints:
    sweep="|".join(AXES) or "none",
    walls="|".join(WALLS) or "none",
    group=r"[A-Za-z0-9][A-Za-z0-9_.-]*",


# Priorities: the jobs of the longest chain (plans, sweeps, the published curves, the paper) are started first; all others use the cores that are left.
rule plan_sweeps:
    input:
        scene=lambda w: local(WALLS[w.walls]),
        robot=lambda w: robot_of_scene(WALLS[w.walls]),
        modules=modules("study.sweeps.plans"),
    output:
        f"{SWEEP_DIR}/plans/{{walls}}/{{batch}}.npz",
    log:
        f"{RESULTS}/logs/plan_sweeps/{{walls}}/{{batch}}.log",
    priority: 3
    conda:
        ENVIRONMENT
    threads: 1
    params:
        poses=most_poses(SWEEP_CASES),
        seeds=lambda w: batch_seeds(w.batch),
    message:
        "Finding postures and casting rays for the sweeps, {wildcards.walls}, {wildcards.batch}"
    script:
        "../scripts/plan_sweeps.py"


rule sweep:
    input:
        scenes=[local(scene) for scene in WALLS.values()],
        robots=sorted({robot for scene in WALLS.values() for robot in robot_of_scene(scene)}),
        plans=[f"{SWEEP_DIR}/plans/{walls}/{{batch}}.npz" for walls in WALLS],
        modules=modules("study.sweeps.run", "study.common.tables"),
    output:
        f"{SWEEP_DIR}/{{sweep}}/cases/{{group}}/{{batch}}.csv",
    log:
        f"{RESULTS}/logs/sweep/{{sweep}}/{{group}}/{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/sweep/{{sweep}}/{{group}}/{{batch}}.tsv"
    priority: 1
    conda:
        ENVIRONMENT
    threads: 1
    params:
        cases=lambda w: {
            case: SWEEP_CASES[w.sweep][case].overrides for case in SWEEP_GROUPS[w.sweep][w.group]
        },
        seeds=lambda w: batch_seeds(w.batch),
        methods=lambda w: [*SWEEPS["methods"], *AXES[w.sweep].get("also", [])],
        walls=list(WALLS),
    message:
        "Sweeping {wildcards.sweep}: {wildcards.group}, {wildcards.batch}"
    script:
        "../scripts/sweep.py"


rule collect_sweep:
    input:
        tables=lambda w: expand(
            rules.sweep.output[0], sweep=w.sweep, group=SWEEP_GROUPS[w.sweep], batch=SWEEP_BATCHES
        ),
        published=resource("published_curves.csv"),
        modules=modules("study.sweeps.summary", "study.common.tables"),
    output:
        errors=f"{SWEEP_DIR}/{{sweep}}/errors.csv",
        summary=report(
            f"{SWEEP_DIR}/{{sweep}}/summary.csv",
            caption="../report/sweep_summary.rst",
            category="Sweeps",
            labels={"sweep": "{sweep}", "walls": "all", "shows": "errors over the seeds"},
        ),
        placed=f"{SWEEP_DIR}/{{sweep}}/published_among_simulated.csv",
    log:
        f"{RESULTS}/logs/collect_sweep/{{sweep}}.log",
    priority: 2
    conda:
        ENVIRONMENT
    threads: 1
    params:
        values=lambda w: values_on_axis(AXES[w.sweep], SWEEP_CASES[w.sweep]),
        published=lambda w: AXES[w.sweep].get("published"),
    message:
        "Collecting the sweep over {wildcards.sweep}"
    script:
        "../scripts/collect_sweep.py"


rule summarise_sweeps:
    input:
        errors=expand(f"{SWEEP_DIR}/{{sweep}}/errors.csv", sweep=AXES),
        placed=expand(f"{SWEEP_DIR}/{{sweep}}/published_among_simulated.csv", sweep=AXES),
        modules=modules("study.sweeps.numbers", "study.common.tables"),
    output:
        numbers=report(
            f"{SWEEP_DIR}/numbers.json",
            caption="../report/sweep_numbers.rst",
            category="Sweeps",
            labels={"sweep": "all", "walls": "all", "shows": "slopes, ratios, edges, failures"},
        ),
        inside=report(
            f"{SWEEP_DIR}/published_inside.csv",
            caption="../report/sweep_published.rst",
            category="Sweeps",
            labels={"sweep": "all", "walls": "all", "shows": "published points among simulated ones"},
        ),
    log:
        f"{RESULTS}/logs/summarise_sweeps.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        labels={name: axis["label"] for name, axis in AXES.items()},
    message:
        "Writing the numbers of the sweeps"
    script:
        "../scripts/summarise_sweeps.py"
