# Closing the first loop: which undeclared effect made the published curves go flat? A config without `first_loop` has none.
FIRST_LOOP = config.get("first_loop") or {}
FIRST_LOOP_OPTIONS = {"first_seed": config["first_seed"], **FIRST_LOOP}
FIRST_LOOP_SWEEPS = {axis["published"]: name for name, axis in AXES.items() if "published" in axis}
FIRST_LOOP_DIR = f"{RESULTS}/first_loop"
FIRST_LOOP_SCENE = ROOT / (FIRST_LOOP.get("scene") or STUDIES["headline"]["scene"])
FIRST_LOOP_TABLES = expand(
    f"{FIRST_LOOP_DIR}/{{name}}",
    name=["candidates.csv", "predictions.csv", "recovery.csv", "coverage.csv", "numbers.json"],
)
FIRST_LOOP_PICTURES = ["curves", "support", "recovery"]
FIRST_LOOP_FIGURES = expand(
    f"{FIRST_LOOP_DIR}/figures/{{name}}.{{suffix}}", name=FIRST_LOOP_PICTURES, suffix=["png", "svg"]
)
if not FIRST_LOOP:
    FIRST_LOOP_TABLES, FIRST_LOOP_FIGURES = [], []


def first_loop_robot(wildcards):
    """Return the robot file of the scene; nothing where the scene holds the robot itself."""
    robot = load_yaml(FIRST_LOOP_SCENE).get("robot")
    return [local((FIRST_LOOP_SCENE.parent / robot).resolve())] if isinstance(robot, str) else []


rule foretell_first_loop:
    input:
        scene=local(FIRST_LOOP_SCENE),
        robot=first_loop_robot,
        published=resource("published_curves.csv"),
        modules=modules("study.published_curves.predict", "study.common.tables"),
    output:
        f"{FIRST_LOOP_DIR}/foretold.npz",
    log:
        f"{RESULTS}/logs/foretell_first_loop.log",
    benchmark:
        f"{RESULTS}/benchmarks/foretell_first_loop.tsv"
    threads: 1
    params:
        options=FIRST_LOOP_OPTIONS,
    message:
        "Predicting the published curves under every candidate"
    script:
        "../scripts/foretell_first_loop.py"


rule close_first_loop:
    input:
        scene=local(FIRST_LOOP_SCENE),
        robot=first_loop_robot,
        published=resource("published_curves.csv"),
        foretold=rules.foretell_first_loop.output[0],
        sweeps=[f"{SWEEP_DIR}/{name}/errors.csv" for name in FIRST_LOOP_SWEEPS.values()],
        modules=modules("study.published_curves.analysis", "study.common.tables"),
    output:
        candidates=report(
            f"{FIRST_LOOP_DIR}/candidates.csv",
            caption="../report/first_loop_candidates.rst",
            category="The first loop",
            labels={"shows": "what the published curves say of each candidate"},
        ),
        predictions=f"{FIRST_LOOP_DIR}/predictions.csv",
        recovery=f"{FIRST_LOOP_DIR}/recovery.csv",
        coverage=f"{FIRST_LOOP_DIR}/coverage.csv",
        numbers=f"{FIRST_LOOP_DIR}/numbers.json",
    log:
        f"{RESULTS}/logs/close_first_loop.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_first_loop.tsv"
    threads: 1
    params:
        options=FIRST_LOOP_OPTIONS,
        sweeps=list(FIRST_LOOP_SWEEPS),
    message:
        "Weighing what made the published curves go flat"
    script:
        "../scripts/close_first_loop.py"


rule draw_first_loop:
    input:
        candidates=rules.close_first_loop.output.candidates,
        predictions=rules.close_first_loop.output.predictions,
        recovery=rules.close_first_loop.output.recovery,
        modules=modules("study.plots.published_curves", "study.common.tables"),
    output:
        **{
            f"{name}_{suffix}": path
            for name in FIRST_LOOP_PICTURES
            for suffix, path in figure(
                f"{FIRST_LOOP_DIR}/figures/{name}", f"figure_first_loop_{name}", "The first loop", shows=name
            ).items()
        },
    log:
        f"{RESULTS}/logs/draw_first_loop.log",
    threads: 1
    message:
        "Drawing what made the published curves go flat"
    script:
        "../scripts/draw_first_loop.py"
