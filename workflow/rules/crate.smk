# A finished run as an RO-Crate: workflow, config and results in one archive, which states what made each file. Not part of the default target.
DEFAULT_RESULTS = [
    *rules.figures.input,
    *rules.summarise_headline.output,
    *SWEEP_NUMBERS,
    *SEQUENTIAL_TABLES,
    *CLAIMS_TABLES,
    *WORKED_EXAMPLE,
    *PUBLISHED_CURVES_TABLES,
    *rules.paper.output,
]


rule crate:
    input:
        results=DEFAULT_RESULTS,
        tables=[path.format(study="headline") for path in rules.collect.output],
        citation=local(ROOT / "CITATION.cff"),
        modules=modules("study.common.crate"),
    output:
        f"{RESULTS}/crate.zip",
    log:
        f"{RESULTS}/logs/crate.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        root=local(ROOT),
        config=config,
    message:
        "Packing results, workflow and config into an RO-Crate"
    script:
        "../scripts/pack_crate.py"
