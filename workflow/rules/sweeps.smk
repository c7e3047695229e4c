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


def sweep_scene(wildcards):
    """Return the scene of a kind of walls."""
    return local(ROOT / WALLS[wildcards.walls])


def sweep_robot(wildcards):
    """Return the robot file of that scene; nothing where the scene holds the robot itself."""
    scene = ROOT / WALLS[wildcards.walls]
    robot = load_yaml(scene).get("robot")
    return [local((scene.parent / robot).resolve())] if isinstance(robot, str) else []


def most_poses():
    """Return the most poses a plane that any case asks for; 1 where none says."""
    asked = [
        case.overrides.get("poses_per_plane", 1) for cases in SWEEP_CASES.values() for case in cases.values()
    ]
    return max(asked, default=1)


def cases_of_sweep(wildcards):
    """Return the tables of all cases, walls and batches of a sweep."""
    return expand(
        f"{SWEEP_DIR}/{wildcards.sweep}/cases/{{case}}/{{walls}}/{{batch}}.csv",
        case=SWEEP_CASES[wildcards.sweep],
        walls=WALLS,
        batch=SWEEP_BATCHES,
    )


rule plan_sweeps:
    input:
        scene=sweep_scene,
        robot=sweep_robot,
        modules=modules("scalar.study.plans"),
    output:
        f"{SWEEP_DIR}/plans/{{walls}}/{{batch}}.json",
    log:
        f"{RESULTS}/logs/plan_sweeps/{{walls}}/{{batch}}.log",
    threads: 1
    params:
        poses=most_poses(),
        seeds=lambda w: batch_seeds(w.batch),
    message:
        "Finding postures for the sweeps, {wildcards.walls}, {wildcards.batch}"
    script:
        "../scripts/plan_sweeps.py"


rule sweep:
    input:
        scene=sweep_scene,
        robot=sweep_robot,
        plans=f"{SWEEP_DIR}/plans/{{walls}}/{{batch}}.json",
        modules=modules("scalar.study.sweep", "scalar.study.tables"),
    output:
        f"{SWEEP_DIR}/{{sweep}}/cases/{{case}}/{{walls}}/{{batch}}.csv",
    log:
        f"{RESULTS}/logs/sweep/{{sweep}}/{{case}}/{{walls}}/{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/sweep/{{sweep}}/{{case}}/{{walls}}/{{batch}}.tsv"
    threads: 1
    params:
        case=lambda w: w.case,
        overrides=lambda w: SWEEP_CASES[w.sweep][w.case].overrides,
        seeds=lambda w: batch_seeds(w.batch),
        methods=SWEEPS["methods"],
    message:
        "Sweeping {wildcards.sweep}: {wildcards.case}, {wildcards.walls}, {wildcards.batch}"
    script:
        "../scripts/sweep.py"


rule collect_sweep:
    input:
        tables=cases_of_sweep,
        published=resource("published_curves.csv"),
        modules=modules("scalar.study.sweeps", "scalar.study.tables"),
    output:
        errors=f"{SWEEP_DIR}/{{sweep}}/errors.csv",
        summary=report(
            f"{SWEEP_DIR}/{{sweep}}/summary.csv",
            caption="../report/sweep_summary.rst",
            category="Sweeps",
            labels={"sweep": "{sweep}", "shows": "errors over the seeds"},
        ),
        placed=f"{SWEEP_DIR}/{{sweep}}/published_among_ours.csv",
    log:
        f"{RESULTS}/logs/collect_sweep/{{sweep}}.log",
    threads: 1
    params:
        values=lambda w: sweep_values(w.sweep),
        walls=lambda w: [Path(path).parent.name for path in cases_of_sweep(w)],
        published=lambda w: AXES[w.sweep].get("published"),
    message:
        "Collecting the sweep over {wildcards.sweep}"
    script:
        "../scripts/collect_sweep.py"
