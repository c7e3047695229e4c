rule evaluate:
    input:
        data=rules.simulate.output[0],
        calibrations=lambda w: expand(
            f"{RESULTS}/{w.study}/calibrations/{w.case}/{{method}}/{w.batch}",
            method=STUDIES[w.study]["methods"],
        ),
        modules=modules("study.headline.evaluate", "study.common.tables"),
    output:
        errors=f"{RESULTS}/{{study}}/evaluations/{{case}}/{{batch}}/errors.csv",
        planes=f"{RESULTS}/{{study}}/evaluations/{{case}}/{{batch}}/planes.csv",
        parameters=f"{RESULTS}/{{study}}/evaluations/{{case}}/{{batch}}/parameters.csv",
    log:
        f"{RESULTS}/logs/evaluate/{{study}}/{{case}}/{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/evaluate/{{study}}/{{case}}/{{batch}}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    params:
        case=lambda w: w.case,
        methods=lambda w: STUDIES[w.study]["methods"],
    message:
        "Evaluating {wildcards.study} {wildcards.case}, {wildcards.batch}"
    script:
        "../scripts/evaluate_seeds.py"


rule collect:
    input:
        errors=evaluations("errors"),
        planes=evaluations("planes"),
        parameters=evaluations("parameters"),
        published_planes=resource("published_plane_errors.csv"),
        modules=modules("study.headline.summary", "study.common.tables"),
    output:
        errors=report(
            f"{RESULTS}/{{study}}/errors.csv",
            caption="../report/errors.rst",
            category="Tables",
            labels={"study": "{study}", "shows": "errors, a row for each seed and method"},
        ),
        planes=f"{RESULTS}/{{study}}/planes.csv",
        parameters=f"{RESULTS}/{{study}}/parameters.csv",
        summary=report(
            f"{RESULTS}/{{study}}/summary.csv",
            caption="../report/summary.rst",
            category="Tables",
            labels={"study": "{study}", "shows": "errors over the seeds"},
        ),
        plane_summary=f"{RESULTS}/{{study}}/plane_summary.csv",
        parameter_summary=report(
            f"{RESULTS}/{{study}}/parameter_summary.csv",
            caption="../report/parameter_summary.rst",
            category="Tables",
            labels={"study": "{study}", "shows": "parameters over the seeds"},
        ),
    log:
        f"{RESULTS}/logs/collect/{{study}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Collecting {wildcards.study}"
    script:
        "../scripts/collect.py"


rule summarise_headline:
    input:
        errors=f"{HEADLINE}/errors.csv",
        summary=f"{HEADLINE}/summary.csv",
        plane_summary=f"{HEADLINE}/plane_summary.csv",
        parameter_summary=f"{HEADLINE}/parameter_summary.csv",
        values=f"{HEADLINE}/identifiability/{FIRST_CASE.name}/singular_values.csv",
        directions=f"{HEADLINE}/identifiability/{FIRST_CASE.name}/null_directions.csv",
        published=resource("published_headline.csv"),
        modules=modules("study.headline.summary", "study.common.tables"),
    output:
        numbers=f"{HEADLINE}/numbers.json",
        placed=report(
            f"{HEADLINE}/published_among_simulated.csv",
            caption="../report/published_among_simulated.rst",
            category="Tables",
            labels={"study": "headline", "shows": "published values among simulated ones"},
        ),
    log:
        f"{RESULTS}/logs/summarise_headline.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        case=FIRST_CASE.name,
    message:
        "Writing the headline's numbers"
    script:
        "../scripts/summarise_headline.py"
