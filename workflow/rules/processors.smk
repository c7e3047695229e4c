# Which numbers of the headline study depend on the processor. Not part of the default target: `snakemake processors` takes some minutes on a machine
# with AVX-512, which can imitate the other processors. The summary is committed:
#   cp results/processors/summaries/* paper/summaries/processors/
from study.processors.kernels import KERNELS

PROCESSORS_DIR = f"{RESULTS}/processors"
PROCESSORS_CASE = FIRST_CASE.name
# The methods of the headline study, and the variant of the baseline whose results depend most on rounding.
PROCESSORS_METHODS = list(dict.fromkeys([*STUDIES["headline"]["methods"], "baseline-abs-2018"]))


wildcard_constraints:
    kernels="|".join(KERNELS),


localrules:
    processors,


rule calibrate_on_processor:
    input:
        data=expand(f"{HEADLINE}/data/{PROCESSORS_CASE}/{{batch}}", batch=batches("headline")),
        modules=modules("study.processors.repeat"),
    output:
        f"{PROCESSORS_DIR}/errors/{{kernels}}.csv",
    log:
        f"{RESULTS}/logs/processors/{{kernels}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        case=PROCESSORS_CASE,
        methods=PROCESSORS_METHODS,
    message:
        "Calibrating the headline's data with the kernels of {wildcards.kernels}"
    script:
        "../scripts/calibrate_on_processor.py"


rule compare_processors:
    input:
        tables=expand(f"{PROCESSORS_DIR}/errors/{{kernels}}.csv", kernels=KERNELS),
        modules=modules("study.processors.compare", "study.common.tables"),
    output:
        table=report(
            f"{PROCESSORS_DIR}/summaries/differences.csv",
            caption="../report/processors.rst",
            category="Tables",
            labels={"study": "headline", "shows": "differences between processors"},
        ),
        numbers=f"{PROCESSORS_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/processors/compare.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        names=list(KERNELS),
    message:
        "Comparing the errors of calibrations between processors"
    script:
        "../scripts/compare_processors.py"


rule processors:
    input:
        rules.compare_processors.output,
