# Explaining the published curves: which effect that the original paper does not mention made its curves go flat? A config without the key
# `published_curves` omits this.
PUBLISHED_CURVES = config.get("published_curves") or {}
PUBLISHED_CURVES_OPTIONS = {"first_seed": config["first_seed"], **PUBLISHED_CURVES}
PUBLISHED_CURVES_SWEEPS = {axis["published"]: name for name, axis in AXES.items() if "published" in axis}
PUBLISHED_CURVES_DIR = f"{RESULTS}/published_curves"
PUBLISHED_CURVES_SCENE = config_path(PUBLISHED_CURVES.get("scene") or STUDIES["headline"]["scene"])
PUBLISHED_CURVES_TABLES = expand(
    f"{PUBLISHED_CURVES_DIR}/{{name}}",
    name=["candidates.csv", "predictions.csv", "recovery.csv", "coverage.csv", "numbers.json"],
)
PUBLISHED_CURVES_PICTURES = ["curves", "support", "recovery"]
PUBLISHED_CURVES_FIGURES = expand(
    f"{PUBLISHED_CURVES_DIR}/figures/{{name}}.{{suffix}}",
    name=PUBLISHED_CURVES_PICTURES,
    suffix=["png", "svg"],
)
if not PUBLISHED_CURVES:
    PUBLISHED_CURVES_TABLES, PUBLISHED_CURVES_FIGURES = [], []


rule predict_published_curves:
    input:
        scene=local(PUBLISHED_CURVES_SCENE),
        robot=lambda w: robot_of_scene(PUBLISHED_CURVES_SCENE),
        published=resource("published_curves.csv"),
        modules=modules("study.published_curves.predict", "study.common.tables"),
    output:
        f"{PUBLISHED_CURVES_DIR}/predicted.npz",
    log:
        f"{RESULTS}/logs/predict_published_curves.log",
    benchmark:
        f"{RESULTS}/benchmarks/predict_published_curves.tsv"
    priority: 2
    conda:
        ENVIRONMENT
    threads: 1
    params:
        options=PUBLISHED_CURVES_OPTIONS,
    message:
        "Predicting the published curves under every candidate explanation"
    script:
        "../scripts/predict_published_curves.py"


rule explain_published_curves:
    input:
        scene=local(PUBLISHED_CURVES_SCENE),
        robot=lambda w: robot_of_scene(PUBLISHED_CURVES_SCENE),
        published=resource("published_curves.csv"),
        predicted=rules.predict_published_curves.output[0],
        sweeps=[f"{SWEEP_DIR}/{name}/errors.csv" for name in PUBLISHED_CURVES_SWEEPS.values()],
        modules=modules("study.published_curves.explain", "study.common.tables"),
    output:
        candidates=report(
            f"{PUBLISHED_CURVES_DIR}/candidates.csv",
            caption="../report/published_curves_candidates.rst",
            category="Published curves",
            labels={"shows": "the support of each candidate by the published curves"},
        ),
        predictions=f"{PUBLISHED_CURVES_DIR}/predictions.csv",
        recovery=f"{PUBLISHED_CURVES_DIR}/recovery.csv",
        coverage=f"{PUBLISHED_CURVES_DIR}/coverage.csv",
        numbers=f"{PUBLISHED_CURVES_DIR}/numbers.json",
    log:
        f"{RESULTS}/logs/explain_published_curves.log",
    benchmark:
        f"{RESULTS}/benchmarks/explain_published_curves.tsv"
    priority: 3
    conda:
        ENVIRONMENT
    threads: 1
    params:
        options=PUBLISHED_CURVES_OPTIONS,
        sweeps=list(PUBLISHED_CURVES_SWEEPS),
    message:
        "Weighing the candidate explanations of the published curves"
    script:
        "../scripts/explain_published_curves.py"


rule draw_published_curves:
    input:
        candidates=rules.explain_published_curves.output.candidates,
        predictions=rules.explain_published_curves.output.predictions,
        recovery=rules.explain_published_curves.output.recovery,
        modules=modules("study.plots.published_curves", "study.common.tables"),
    output:
        **{
            f"{name}_{suffix}": path
            for name in PUBLISHED_CURVES_PICTURES
            for suffix, path in figure(
                f"{PUBLISHED_CURVES_DIR}/figures/{name}",
                f"figure_published_curves_{name}",
                "Published curves",
                shows=name,
            ).items()
        },
    log:
        f"{RESULTS}/logs/draw_published_curves.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Drawing the candidate explanations of the published curves"
    script:
        "../scripts/draw_published_curves.py"
