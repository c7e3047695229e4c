# The confidence is fitted to the answers of trials of several designs; what is reported of each half of the trials follows from the fit to the other
# half. It is not part of the default target; a run that was stopped goes on where it was. The fitted coefficients are part of the package, and the
# tables are committed:
#   snakemake confidence --cores 2
#   cp results/confidence/coefficients.json scalar/diagnosis/naming/confidence_coefficients.json
#   cp results/confidence/{answers.csv,reliability.csv,reliability_by_poses.csv,numbers.json} paper/summaries/confidence/
CONFIDENCE_DIR = f"{RESULTS}/confidence"
try:
    CONFIDENCE_CONFIGS = {
        Path(path).stem: config_path(path)
        for path in config.get(
            "confidence",
            [
                "configs/blind_trials_confidence.yaml",
                "configs/blind_trials_components.yaml",
                "configs/blind_trials_eleventh_exam.yaml",
                "configs/blind_trials_twelfth_exam.yaml",
                "configs/blind_trials_few_poses.yaml",
                "configs/blind_trials_white_scanners.yaml",
            ],
        )
    }
    CONFIDENCE_DESIGNS = {name: load_design(path) for name, path in CONFIDENCE_CONFIGS.items()}
    CONFIDENCE_TRACKED_CONFIG = config_path(
        config.get("confidence_tracked", "configs/tracked_trials_first_exam.yaml")
    )
    CONFIDENCE_TRACKED = load_tracked(CONFIDENCE_TRACKED_CONFIG)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None


wildcard_constraints:
    design="|".join(CONFIDENCE_DESIGNS),


localrules:
    confidence,


use rule run_stratified_trials as run_confidence_trials with:
    output:
        f"{CONFIDENCE_DIR}/sets/{{design}}/{{numbers}}.csv",
    log:
        f"{RESULTS}/logs/confidence/{{design}}/{{numbers}}.log",
    params:
        config=lambda w: local(CONFIDENCE_CONFIGS[w.design]),
        root=local(ROOT),
        # The design without the number of sets: an edit of it runs all jobs again, but a larger number of sets adds jobs only.
        design=lambda w: repr({k: v for k, v in CONFIDENCE_DESIGNS[w.design].content.items() if k != "sets"}),
    message:
        "Trials for the confidence, {wildcards.design}: sets {wildcards.numbers}"


use rule run_tracked_trials as run_tracked_confidence_trials with:
    output:
        f"{CONFIDENCE_DIR}/sets/tracked/{{sensor}}/{{numbers}}.csv",
    log:
        f"{RESULTS}/logs/confidence/tracked/{{sensor}}/{{numbers}}.log",
    params:
        config=local(CONFIDENCE_TRACKED_CONFIG),
        design=repr({k: v for k, v in CONFIDENCE_TRACKED.content.items() if k != "sets"}),
    message:
        "Trials for the confidence, {wildcards.sensor}: sets {wildcards.numbers}"


rule fit_confidence:
    input:
        sets=[
            f"{CONFIDENCE_DIR}/sets/{name}/{job}.csv"
            for name, design in CONFIDENCE_DESIGNS.items()
            for job in design.jobs()
        ],
        tracked=[
            f"{CONFIDENCE_DIR}/sets/tracked/{sensor}/{job}.csv" for sensor, job in CONFIDENCE_TRACKED.jobs()
        ],
        modules=modules("study.confidence.fit", "study.confidence.answers", "study.common.tables"),
    output:
        coefficients=f"{CONFIDENCE_DIR}/coefficients.json",
        answers=f"{CONFIDENCE_DIR}/answers.csv",
        reliability=f"{CONFIDENCE_DIR}/reliability.csv",
        by_poses=f"{CONFIDENCE_DIR}/reliability_by_poses.csv",
        numbers=f"{CONFIDENCE_DIR}/numbers.json",
    log:
        f"{RESULTS}/logs/confidence/fit.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Fitting the confidence to the trials"
    script:
        "../scripts/fit_confidence.py"


rule draw_confidence:
    input:
        reliability=rules.fit_confidence.output.reliability,
        modules=modules("study.plots.confidence", "study.common.tables"),
    output:
        **figure(
            f"{CONFIDENCE_DIR}/figures/reliability",
            "figure_confidence",
            "Blind trials",
            shows="confidence",
        ),
    log:
        f"{RESULTS}/logs/confidence/draw.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Drawing how often answers are right, by their stated confidence"
    script:
        "../scripts/draw_confidence.py"


rule confidence:
    input:
        rules.fit_confidence.output,
        rules.draw_confidence.output,
