# The measured robots: the published files are fetched, imported and diagnosed, and models are compared on held-out poses. This is not part of the
# default target. The summaries contain no measured data and are small enough to be committed, for the paper:
#   cp results/measured/summaries/* paper/summaries/measured/
from snakemake.logging import logger

from study.measured.at_hand import SetsAtHand
from study.measured.originals import read_originals

MEASURED = f"{RESULTS}/measured"
ORIGINALS = read_originals(ROOT / "workflow/resources/measured.csv")
FOLDER = (config.get("measured") or {}).get("folder") or ""
ADDRESSES = (config.get("measured") or {}).get(
    "addresses",
    [
        "https://github.com/{repository}/raw/{commit}/{path}",
        "https://raw.githubusercontent.com/{repository}/HEAD/{path}",
    ],
)
MEASURED_FIGURES = ["errors", "gears"]
TRANSFERS = {  # set: the campaign whose effects are applied to it
    "ur10_tracker_d": "ur10_tracker_c",
    "iiwa7_1250g": "iiwa7_2500g",
    "iiwa7_2500g": "iiwa7_1250g",
    "irb120_test_30": "irb120",
}
AT_HAND = SetsAtHand(ORIGINALS, FOLDER, ADDRESSES, Path(f"{MEASURED}/originals"), TRANSFERS, logger.warning)


rule get_originals:
    output:
        directory(f"{MEASURED}/originals/{{set}}"),
    log:
        f"{RESULTS}/logs/measured/get_originals/{{set}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    resources:  # not params: another folder must not run the job again, since the files are identified by their checksums
        folder=FOLDER,
    params:
        addresses=lambda w: ADDRESSES,
        listed=local(ROOT / "workflow/resources/measured.csv"),
    message:
        "Getting the originals of {wildcards.set}"
    script:
        "../scripts/get_originals.py"


rule import_measured:
    input:
        originals=rules.get_originals.output[0],
        mapping=lambda w: local(ROOT / f"configs/measured/{ORIGINALS[w.set][0].mapping}.yaml"),
        modules=modules("scalar.ingest.convert"),
    output:
        directory(f"{MEASURED}/{{set}}/dataset"),
    log:
        f"{RESULTS}/logs/measured/import/{{set}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Importing {wildcards.set}"
    script:
        "../scripts/import_measured.py"


rule diagnose_measured:
    input:
        dataset=rules.import_measured.output[0],
        modules=modules("scalar.diagnosis", "scalar.report"),
    output:
        before=f"{MEASURED}/{{set}}/before.json",
        after=f"{MEASURED}/{{set}}/after.json",
        diagnosis=f"{MEASURED}/{{set}}/diagnosis.json",
        page=report(
            f"{MEASURED}/{{set}}/report.html",
            caption="../report/measured_diagnosis.rst",
            category="Measured robots",
            labels={"set": "{set}", "shows": "diagnosis"},
        ),
    log:
        f"{RESULTS}/logs/measured/diagnose/{{set}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/measured/diagnose/{{set}}.tsv"
    conda:
        ENVIRONMENT
    threads: workflow.cores  # the runs of the outer split take all that the job may use
    message:
        "Diagnosing {wildcards.set}"
    script:
        "../scripts/diagnose_measured.py"


rule compare_measured:
    input:
        dataset=rules.import_measured.output[0],
        modules=modules("study.measured.models"),
    output:
        f"{MEASURED}/{{set}}/models.json",
    log:
        f"{RESULTS}/logs/measured/compare/{{set}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Predicting held-out poses of {wildcards.set} by models without effects"
    script:
        "../scripts/compare_measured.py"


rule transfer_measured:
    input:
        dataset=rules.import_measured.output[0],
        effects=lambda w: f"{MEASURED}/{TRANSFERS[w.set]}/after.json",
        modules=modules("study.measured.models", "scalar.estimation.calibrate"),
    output:
        calibration=f"{MEASURED}/{{set}}/transferred/calibration.json",
        errors=f"{MEASURED}/{{set}}/transferred/models.json",
    log:
        f"{RESULTS}/logs/measured/transfer/{{set}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        source=lambda w: TRANSFERS[w.set],
    message:
        "Calibrating {wildcards.set} with the effects of {params.source}"
    script:
        "../scripts/transfer_measured.py"


rule check_measured:
    input:
        dataset=rules.import_measured.output[0],
        found=rules.diagnose_measured.output.after,
        modules=modules("study.measured.models", "study.measured.gears"),
    output:
        checks=f"{MEASURED}/{{set}}/checks.json",
        gears=f"{MEASURED}/{{set}}/gears.csv",
    log:
        f"{RESULTS}/logs/measured/check/{{set}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Checking what was found in {wildcards.set}, with another split and with shuffled angles"
    script:
        "../scripts/check_measured.py"


rule summarise_measured:
    input:
        originals=lambda w: expand(rules.get_originals.output[0], set=AT_HAND.names),
        datasets=lambda w: expand(rules.import_measured.output[0], set=AT_HAND.names),
        diagnoses=lambda w: expand(rules.diagnose_measured.output.diagnosis, set=AT_HAND.names),
        errors=lambda w: expand(rules.compare_measured.output[0], set=AT_HAND.names),
        transfers=lambda w: expand(rules.transfer_measured.output.errors, set=AT_HAND.transferred),
        checks=lambda w: expand(rules.check_measured.output.checks, set=AT_HAND.names),
        gears=lambda w: expand(rules.check_measured.output.gears, set=AT_HAND.names),
        modules=modules(
            "study.measured.models",
            "study.measured.originals",
            "study.measured.gears",
            "study.measured.repeated",
        ),
    output:
        summary=f"{MEASURED}/summaries/numbers.json",
        table=report(
            f"{MEASURED}/summaries/errors.csv",
            caption="../report/measured_summary.rst",
            category="Measured robots",
            labels={"set": "all", "shows": "held-out errors, a row for each set and model"},
        ),
        gears=f"{MEASURED}/summaries/gears.csv",
    log:
        f"{RESULTS}/logs/measured/summarise.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        sets=lambda w: AT_HAND.names,
        transfers=lambda w: AT_HAND.transferred,
    message:
        "Summarising the measured sets"
    script:
        "../scripts/summarise_measured.py"


rule draw_measured:
    input:
        errors=rules.summarise_measured.output.table,
        gears=rules.summarise_measured.output.gears,
        modules=modules("study.plots.measured", "study.common.tables"),
    output:
        **{
            f"{name}_{suffix}": path
            for name in MEASURED_FIGURES
            for suffix, path in figure(
                f"{MEASURED}/figures/{name}",
                f"figure_measured_{name}",
                "Measured robots",
                set="all",
                shows=name,
            ).items()
        },
    log:
        f"{RESULTS}/logs/measured/draw.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Drawing the measured robots"
    script:
        "../scripts/draw_measured.py"


rule measured:
    input:
        lambda w: [*rules.summarise_measured.output, *rules.draw_measured.output] if AT_HAND.names else [],
