# Judge every claim of the original paper by this run's tables; claims whose table the run lacks are "not in this run".
CLAIMS_DIR = f"{RESULTS}/claims"
CLAIMED_SWEEPS = [name for name in ("noise", "poses", "points", "plane_offset", "plane_tilt") if name in AXES]
CLAIMS_TABLES = [f"{CLAIMS_DIR}/claims.csv", f"{CLAIMS_DIR}/claims.json"]


rule judge_claims:
    input:
        claims=resource("judged_claims.csv"),
        headline=f"{HEADLINE}/summary.csv",
        planes=f"{HEADLINE}/planes.csv",
        singular_values=f"{HEADLINE}/identifiability/{FIRST_CASE.name}/singular_values.csv",
        arms=f"{HEADLINE}/identifiability/other_arms.csv",
        workspace=f"{HEADLINE}/workspace.csv" if PROPOSED in STUDIES["headline"]["methods"] else [],
        seeds=f"{HEADLINE}/workspace.json" if PROPOSED in STUDIES["headline"]["methods"] else [],
        sequential=f"{SEQUENTIAL_DIR}/summary.csv" if "sequential" in config else [],
        sweeps=expand(f"{SWEEP_DIR}/{{sweep}}/summary.csv", sweep=CLAIMED_SWEEPS),
        modules=modules("study.claims.numbers", "study.common.tables"),
    output:
        table=report(
            f"{CLAIMS_DIR}/claims.csv",
            caption="../report/claims.rst",
            category="Claims",
            labels={"shows": "claims of the paper, judged by this run"},
        ),
        numbers=f"{CLAIMS_DIR}/claims.json",
    log:
        f"{RESULTS}/logs/judge_claims.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        case=FIRST_CASE.name,
        sweeps=CLAIMED_SWEEPS,
        benchmarks={
            method: expand(
                f"{RESULTS}/benchmarks/calibrate/headline/{FIRST_CASE.name}/{method}/{{batch}}.tsv",
                batch=batches("headline"),
            )
            for method in STUDIES["headline"]["methods"]
        },
        seeds=STUDIES["headline"]["seeds"],
    message:
        "Judging the paper's claims"
    script:
        "../scripts/judge_claims.py"
