# Sweeps: errors over one key of the scene, a figure a sweep and kind of walls. A config without `sweeps` has none.
SWEEPS = config.get("sweeps") or {"axes": {}, "walls": {}, "methods": [], "seeds": 1, "seeds_per_job": 1}
AXES = SWEEPS["axes"]
WALLS = SWEEPS["walls"]
SWEEP_CASES = checked_grids(AXES)
SWEEP_BATCHES = batch_names(config["first_seed"], SWEEPS["seeds"], SWEEPS["seeds_per_job"])
SWEEP_DIR = f"{RESULTS}/sweeps"
SWEEP_FIGURES = expand(
    f"{SWEEP_DIR}/{{sweep}}/figures/{{walls}}.{{suffix}}", sweep=AXES, walls=WALLS, suffix=["png", "svg"]
)

SWEEP_NUMBERS = [f"{SWEEP_DIR}/numbers.json"] if AXES else []

for name, axis in AXES.items():
    for case in SWEEP_CASES[name].values():
        if axis["key"] not in case.overrides or case.scene:
            raise WorkflowError(
                f"{axis['grid']}, case {case.name}: a sweep's grid states {axis['key']} in every row, and no scene"
            )


wildcard_constraints:
    sweep="|".join(AXES) or "none",
    walls="|".join(WALLS) or "none",


def sweep_values(sweep):
    """Return {case: value on the axis, in the unit of its label}."""
    axis = AXES[sweep]
    factor = axis.get("factor", 1)
    return {name: case.overrides[axis["key"]] * factor for name, case in SWEEP_CASES[sweep].items()}


def scene_of_walls(walls):
    """Return the scene of a kind of walls."""
    return local(ROOT / WALLS[walls])


def robot_of_walls(walls):
    """Return the robot file of that scene; nothing where the scene holds the robot itself."""
    scene = ROOT / WALLS[walls]
    robot = load_yaml(scene).get("robot")
    return [local((scene.parent / robot).resolve())] if isinstance(robot, str) else []


def most_poses():
    """Return the most poses a plane that any case asks for; 1 where none says."""
    asked = [
        case.overrides.get("poses_per_plane", 1) for cases in SWEEP_CASES.values() for case in cases.values()
    ]
    return max(asked, default=1)


def cases_of_sweep(wildcards):
    """Return the tables of all cases and batches of a sweep."""
    return expand(
        f"{SWEEP_DIR}/{wildcards.sweep}/cases/{{case}}/{{batch}}.csv",
        case=SWEEP_CASES[wildcards.sweep],
        batch=SWEEP_BATCHES,
    )


rule plan_sweeps:
    input:
        scene=lambda w: scene_of_walls(w.walls),
        robot=lambda w: robot_of_walls(w.walls),
        modules=modules("study.sweeps.plans"),
    output:
        f"{SWEEP_DIR}/plans/{{walls}}/{{batch}}.npz",
    log:
        f"{RESULTS}/logs/plan_sweeps/{{walls}}/{{batch}}.log",
    threads: 1
    params:
        poses=most_poses(),
        seeds=lambda w: batch_seeds(w.batch),
    message:
        "Finding postures and casting rays for the sweeps, {wildcards.walls}, {wildcards.batch}"
    script:
        "../scripts/plan_sweeps.py"


rule sweep:
    input:
        scenes=[scene_of_walls(walls) for walls in WALLS],
        robots=sorted({path for walls in WALLS for path in robot_of_walls(walls)}),
        plans=[f"{SWEEP_DIR}/plans/{walls}/{{batch}}.npz" for walls in WALLS],
        modules=modules("study.sweeps.run", "study.common.tables"),
    output:
        f"{SWEEP_DIR}/{{sweep}}/cases/{{case}}/{{batch}}.csv",
    log:
        f"{RESULTS}/logs/sweep/{{sweep}}/{{case}}/{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/sweep/{{sweep}}/{{case}}/{{batch}}.tsv"
    threads: 1
    params:
        case=lambda w: w.case,
        overrides=lambda w: SWEEP_CASES[w.sweep][w.case].overrides,
        seeds=lambda w: batch_seeds(w.batch),
        methods=SWEEPS["methods"],
        walls=list(WALLS),
    message:
        "Sweeping {wildcards.sweep}: {wildcards.case}, {wildcards.batch}"
    script:
        "../scripts/sweep.py"


rule collect_sweep:
    input:
        tables=cases_of_sweep,
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
    threads: 1
    params:
        values=lambda w: sweep_values(w.sweep),
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
            labels={"sweep": "all", "walls": "all", "shows": "published points among ours"},
        ),
    log:
        f"{RESULTS}/logs/summarise_sweeps.log",
    threads: 1
    params:
        labels={name: axis["label"] for name, axis in AXES.items()},
    message:
        "Writing the numbers of the sweeps"
    script:
        "../scripts/summarise_sweeps.py"
