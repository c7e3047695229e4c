# The study of coverage: how often the true position lies within the ellipsoid that is stated for a predicted pose. It is not part of the default
# target: `snakemake coverage` runs it, and goes on with a run that was stopped. The summaries are committed:
#   cp results/coverage/summaries/* paper/summaries/coverage/
from study.coverage.design import load_coverage

try:
    COVERAGE_CONFIG = config_path(config.get("coverage", "configs/coverage.yaml"))
    COVERAGE = load_coverage(COVERAGE_CONFIG)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None
COVERAGE_DIR = f"{RESULTS}/coverage"


localrules:
    coverage,


rule run_coverage:
    input:
        arms=[local(path) for path in sorted((ROOT / "scalar/robots/arms").glob("*.yaml"))],
        modules=modules("study.coverage.run", "study.common.tables"),
    output:
        f"{COVERAGE_DIR}/workcells/{{numbers}}.csv",
    log:
        f"{RESULTS}/logs/coverage/{{numbers}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(COVERAGE_CONFIG),
        # The design without the number of workcells: an edit of it runs all jobs again, but a larger number adds jobs only.
        design=repr({k: v for k, v in COVERAGE.content.items() if k != "workcells"}),
    message:
        "Coverage of predicted poses: workcells {wildcards.numbers}"
    script:
        "../scripts/run_coverage.py"


rule summarise_coverage:
    input:
        workcells=[f"{COVERAGE_DIR}/workcells/{job}.csv" for job in COVERAGE.jobs()],
        modules=modules("study.coverage.summaries", "study.common.tables"),
    output:
        table=f"{COVERAGE_DIR}/summaries/table.csv",
        numbers=f"{COVERAGE_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/coverage/summarise.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        design=COVERAGE.content,
    message:
        "Summarising the coverage of predicted poses"
    script:
        "../scripts/summarise_coverage.py"


rule coverage:
    input:
        rules.summarise_coverage.output,
