rule calibrate:
    input:
        data=rules.simulate.output[0],
        modules=modules("study.headline.calibrate"),
    output:
        directory(f"{RESULTS}/{{study}}/calibrations/{{case}}/{{method}}/{{batch}}"),
    log:
        f"{RESULTS}/logs/calibrate/{{study}}/{{case}}/{{method}}/{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/calibrate/{{study}}/{{case}}/{{method}}/{{batch}}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    params:
        method=lambda w: w.method,
    message:
        "Calibrating {wildcards.study} {wildcards.case}, {wildcards.method}, {wildcards.batch}"
    script:
        "../scripts/calibrate_seeds.py"


rule estimate_linearly:
    input:
        data=expand(f"{HEADLINE}/data/{FIRST_CASE.name}/{{batch}}", batch=batches("headline")),
        modules=modules("study.headline.linear_estimate", "study.common.tables"),
    output:
        table=report(
            f"{HEADLINE}/linear_estimate.csv",
            caption="../report/linear_estimate.rst",
            category="Tables",
            labels={"study": "headline", "shows": "the linear estimate of the scanner's pose"},
        ),
        numbers=f"{HEADLINE}/linear_estimate.json",
    log:
        f"{RESULTS}/logs/estimate_linearly.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Estimating the scanner's pose linearly"
    script:
        "../scripts/estimate_linearly.py"


rule tabulate_identifiability:
    input:
        data=lambda w: f"{RESULTS}/{w.study}/data/{w.case}/{batches(w.study)[0]}",
        modules=modules("study.headline.identifiability", "study.common.tables"),
    output:
        values=f"{RESULTS}/{{study}}/identifiability/{{case}}/singular_values.csv",
        directions=report(
            f"{RESULTS}/{{study}}/identifiability/{{case}}/null_directions.csv",
            caption="../report/null_directions.rst",
            category="Identifiability",
            labels={"study": "{study}", "case": "{case}", "shows": "null directions"},
        ),
    log:
        f"{RESULTS}/logs/tabulate_identifiability/{{study}}/{{case}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Finding what the poses of {wildcards.study} {wildcards.case} determine"
    script:
        "../scripts/tabulate_identifiability.py"


rule tabulate_other_arms:
    input:
        scene=local(config_path(STUDIES["headline"]["scene"])),
        modules=modules("study.headline.other_arms", "study.common.tables"),
    output:
        table=report(
            f"{HEADLINE}/identifiability/other_arms.csv",
            caption="../report/other_arms.rst",
            category="Identifiability",
            labels={"study": "headline", "shows": "what other six-axis arms need"},
        ),
        numbers=f"{HEADLINE}/identifiability/other_arms.json",
    log:
        f"{RESULTS}/logs/tabulate_other_arms.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Finding what three planes determine of other arms"
    script:
        "../scripts/tabulate_other_arms.py"
