# Figures from tables: each rule draws a table without further computation. A figure is written as PNG, which the report shows, and as SVG for print.
rule draw_errors:
    input:
        errors=f"{HEADLINE}/errors.csv",
        summary=f"{HEADLINE}/summary.csv",
        published=resource("published_headline.csv"),
        modules=modules("study.plots.errors", "study.common.tables"),
    output:
        **figure(
            f"{HEADLINE}/figures/errors{{case_suffix}}",
            "figure_errors",
            "Headline",
            case=case_of_figure,
            shows="errors before and after",
        ),
    log:
        f"{RESULTS}/logs/draw_errors{{case_suffix}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        case=case_of_figure,
    script:
        "../scripts/draw_errors.py"


rule draw_initial:
    input:
        errors=f"{HEADLINE}/errors.csv",
        placed=f"{HEADLINE}/published_among_simulated.csv",
        modules=modules("study.plots.initial", "study.common.tables"),
    output:
        **figure(f"{HEADLINE}/figures/initial", "figure_initial", "Headline", shows="initial models"),
    log:
        f"{RESULTS}/logs/draw_initial.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        case=FIRST_CASE.name,
    script:
        "../scripts/draw_initial.py"


rule draw_planes:
    input:
        planes=f"{HEADLINE}/planes.csv",
        published=resource("published_plane_errors.csv"),
        modules=modules("study.plots.planes", "study.common.tables"),
    output:
        **figure(
            f"{HEADLINE}/figures/planes{{case_suffix}}",
            "figure_planes",
            "Headline",
            case=case_of_figure,
            shows="planes against the truth",
        ),
    log:
        f"{RESULTS}/logs/draw_planes{{case_suffix}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        case=case_of_figure,
    script:
        "../scripts/draw_planes.py"


rule draw_parameters:
    input:
        parameters=f"{HEADLINE}/parameters.csv",
        summary=f"{HEADLINE}/parameter_summary.csv",
        modules=modules("study.plots.parameters", "study.common.tables"),
    output:
        **figure(
            f"{HEADLINE}/figures/parameters_{{method}}{{case_suffix}}",
            "figure_parameters",
            "Headline",
            case=case_of_figure,
            shows="parameters with standard errors, {method}",
        ),
    log:
        f"{RESULTS}/logs/draw_parameters_{{method}}{{case_suffix}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        case=case_of_figure,
        method=lambda w: w.method,
    script:
        "../scripts/draw_parameters.py"


rule draw_singular_values:
    input:
        values=f"{RESULTS}/{{study}}/identifiability/{{case}}/singular_values.csv",
        directions=f"{RESULTS}/{{study}}/identifiability/{{case}}/null_directions.csv",
        modules=modules("study.plots.identifiability", "study.common.tables"),
    output:
        **figure(
            f"{RESULTS}/{{study}}/figures/singular_values_{{case}}",
            "figure_singular_values",
            "Identifiability",
            study="{study}",
            case="{case}",
            shows="singular values",
        ),
    log:
        f"{RESULTS}/logs/draw_singular_values_{{study}}_{{case}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    script:
        "../scripts/draw_singular_values.py"


rule draw_sweep:
    input:
        summary=f"{SWEEP_DIR}/{{sweep}}/summary.csv",
        published=resource("published_curves.csv"),
        modules=modules("study.plots.sweep", "study.common.tables"),
    output:
        **figure(
            f"{SWEEP_DIR}/{{sweep}}/figures/{{walls}}",
            "figure_sweep",
            "Sweeps",
            sweep="{sweep}",
            walls="{walls}",
            shows="errors, bands over the seeds",
        ),
    log:
        f"{RESULTS}/logs/draw_sweep/{{sweep}}_{{walls}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        axis=lambda w: {
            key: value for key, value in AXES[w.sweep].items() if key in ("label", "scale", "published")
        },
        walls=lambda w: w.walls,
    script:
        "../scripts/draw_sweep.py"


rule figures:
    input:
        expand(
            f"{HEADLINE}/figures/{{name}}.{{suffix}}",
            name=[
                "initial",
                *(f"{name}{suffix}" for suffix in CASE_OF_FIGURE for name in ("errors", "planes")),
                *(
                    f"parameters_{method}{suffix}"
                    for suffix in CASE_OF_FIGURE
                    for method in STUDIES["headline"]["methods"]
                ),
                *(f"singular_values_{case}" for case in CASES["headline"]),
            ],
            suffix=["png", "svg"],
        ),
        SWEEP_FIGURES,
        SEQUENTIAL_FIGURES,
        SCENE_FIGURES,
        PUBLISHED_CURVES_FIGURES,
