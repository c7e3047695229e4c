# Further figures of the headline: the workcell, the correlations of the parameters, and where in the workspace the errors lie.
from types import SimpleNamespace

FIRST_BATCH = batches("headline")[0]
OF_FIRST_CASE = SimpleNamespace(study="headline", case=FIRST_CASE.name)
SCENE_FIGURES = expand(
    f"{HEADLINE}/figures/{{name}}.{{suffix}}",
    name=["scene", *(["correlation", "workspace"] if PROPOSED in STUDIES["headline"]["methods"] else [])],
    suffix=["png", "svg"],
)


rule render_scene:
    input:
        scene=local(scene_path(OF_FIRST_CASE)),
        robot=robot_of_scene(scene_path(OF_FIRST_CASE)),
        modules=modules("study.headline.picture"),
    output:
        picture=f"{HEADLINE}/scene/picture.png",
        places=f"{HEADLINE}/scene/places.json",
    log:
        f"{RESULTS}/logs/render_scene.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        overrides=FIRST_CASE.overrides,
        seed=config["first_seed"],
    message:
        "Drawing the workcell by pybullet's renderer"
    script:
        "../scripts/render_scene.py"


rule correlate:
    input:
        calibrations=f"{HEADLINE}/calibrations/{FIRST_CASE.name}/{PROPOSED}/{FIRST_BATCH}",
        modules=modules("study.headline.workspace", "study.common.tables"),
    output:
        report(
            f"{HEADLINE}/correlation.csv",
            caption="../report/correlation.rst",
            category="Tables",
            labels={"study": "headline", "shows": "correlations of the parameters"},
        ),
    log:
        f"{RESULTS}/logs/correlate.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Writing the correlations of the first seed's parameters"
    script:
        "../scripts/correlate.py"


rule map_workspace:
    input:
        data=expand(f"{HEADLINE}/data/{FIRST_CASE.name}/{{batch}}", batch=batches("headline")),
        calibrations=expand(
            f"{HEADLINE}/calibrations/{FIRST_CASE.name}/{PROPOSED}/{{batch}}", batch=batches("headline")
        ),
        modules=modules("study.headline.workspace", "study.common.tables"),
    output:
        errors=f"{HEADLINE}/workspace.csv",
        seeds=f"{HEADLINE}/workspace.json",
    log:
        f"{RESULTS}/logs/map_workspace.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Mapping the errors over the workspace"
    script:
        "../scripts/map_workspace.py"


rule draw_scene:
    input:
        picture=rules.render_scene.output.picture,
        places=rules.render_scene.output.places,
        modules=modules("study.plots.scene"),
    output:
        **figure(f"{HEADLINE}/figures/scene", "figure_scene", "Headline", shows="the workcell"),
    log:
        f"{RESULTS}/logs/draw_scene.log",
    conda:
        ENVIRONMENT
    threads: 1
    script:
        "../scripts/draw_scene.py"


rule draw_correlation:
    input:
        correlation=rules.correlate.output[0],
        modules=modules("study.plots.correlation", "study.common.tables"),
    output:
        **figure(
            f"{HEADLINE}/figures/correlation",
            "figure_correlation",
            "Identifiability",
            shows="correlations of the parameters",
        ),
    log:
        f"{RESULTS}/logs/draw_correlation.log",
    conda:
        ENVIRONMENT
    threads: 1
    script:
        "../scripts/draw_correlation.py"


rule draw_workspace:
    input:
        errors=rules.map_workspace.output.errors,
        seeds=rules.map_workspace.output.seeds,
        modules=modules("study.plots.workspace", "study.common.tables"),
    output:
        **figure(
            f"{HEADLINE}/figures/workspace",
            "figure_workspace",
            "Headline",
            shows="errors over the workspace",
        ),
    log:
        f"{RESULTS}/logs/draw_workspace.log",
    conda:
        ENVIRONMENT
    threads: 1
    script:
        "../scripts/draw_workspace.py"
