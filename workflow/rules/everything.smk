# Everything by one version of the code: the default target, the studies that are not part of it, and a second paper, which takes its numbers from the
# summaries of this run instead of the committed ones. It takes many hours on two cores, and needs the files of the measured robots.
#   snakemake everything --cores 2
FRESH_SUMMARIES = {
    "blind_trials": f"{TRIALS_DIR}/summaries",
    "confidence": CONFIDENCE_DIR,
    "measured": f"{MEASURED}/summaries",
    "sensitivity": f"{SENSITIVITY_DIR}/summaries",
    "processors": f"{PROCESSORS_DIR}/summaries",
    "leaning_walls": LEANING_SUMMARIES,
    "edges": f"{EDGES_DIR}/summaries",
    "starts": STARTS_DIR,
}
FRESH_NUMBERS = PAPER_NUMBERS | {
    part: path
    for part, path in {
        **{part: f"{folder}/numbers.json" for part, folder in FRESH_SUMMARIES.items()},
        "planning": f"{PLANNING_DIR}/numbers.json",
        "separation": f"{PLANNING_DIR}/separation.json",
    }.items()
    if part in PAPER_NUMBERS
}
FRESH_FIGURES = {
    name: (
        f"{RESULTS}/{Path(name).parent}/figures/{Path(name).name}"
        if Path(name).parts[0] in FRESH_SUMMARIES
        else path
    )
    for name, path in PAPER_FIGURES.items()
}


localrules:
    everything,


use rule gather_numbers as gather_fresh_numbers with:
    input:
        parts=list(FRESH_NUMBERS.values()),
        scene=local(config_path(STUDIES["headline"]["scene"])),
        tilted=local(ROOT / "configs/scenes/paper_tilted.yaml"),
        headline=resource("published_headline.csv"),
        planes=resource("published_plane_errors.csv"),
        curves=resource("published_curves.csv"),
        claims=resource("published_claims.csv"),
        followup=resource("published_followup.csv"),
        published_measured=resource("published_measured.csv"),
        judged=resource("judged_claims.csv"),
        trials=[f"{TRIALS_DIR}/summaries/{path.name}" for path in TRIALS_REPORTED],
        stratified=[local(path) for path in STRATIFIED_REPORTED],
        exams=[local(path) for path in EXAM_RECORDS],
        ratios=local(STRATIFIED_SUMMARIES / "ratios.csv") if STRATIFIED_REPORTED else [],
        conditions=local(STRATIFIED_SUMMARIES / "conditions.csv") if STRATIFIED_REPORTED else [],
        confidence=local(STRATIFIED_SUMMARIES / "confidence.csv") if STRATIFIED_REPORTED else [],
        separation=f"{PLANNING_DIR}/separation.csv" if "separation" in PAPER_NUMBERS else [],
        correlation=f"{HEADLINE}/correlation.csv" if "headline/correlation.svg" in PAPER_FIGURES else [],
        workspace=f"{HEADLINE}/workspace.csv" if "headline/workspace.svg" in PAPER_FIGURES else [],
        rivals=local(BENCHMARK_TABLE) if "benchmark" in PAPER_NUMBERS else [],
        modules=modules(
            "study.paper.numbers",
            "study.paper.committed",
            "study.paper.measured_published",
            "study.paper.measured_rivals",
            "study.paper.parts",
            "study.paper.trials",
            "study.common.tables",
        ),
    output:
        f"{RESULTS}/everything/numbers.json",
    log:
        f"{RESULTS}/logs/everything/gather_numbers.log",
    params:
        parts=FRESH_NUMBERS,
        trials=[path.stem for path in TRIALS_REPORTED],
        seeds=STUDIES["headline"]["seeds"],
        draft=config.get("paper", {}).get("draft", False),
    message:
        "Gathering the numbers of everything"


use rule paper as fresh_paper with:
    input:
        numbers=rules.gather_fresh_numbers.output[0],
        text=[local(path) for path in sorted(PAPER.rglob("*")) if path.suffix in (".typ", ".bib")],
        figures=list(FRESH_FIGURES.values()),
        modules=modules("study.paper.typeset"),
    output:
        f"{RESULTS}/everything/paper.pdf",
    log:
        f"{RESULTS}/logs/everything/paper.log",
    params:
        text=lambda w, input: os.path.commonpath(input.text),
        figures=FRESH_FIGURES,
    message:
        "Typesetting the paper from summaries of one version"


rule everything:
    input:
        rules.all.input,
        rules.blind_trials.input,
        rules.blind_trials_stratified.input,
        rules.tracked_trials.input,
        rules.spoiled_setups.input,
        rules.coverage.input,
        rules.real_arm_trials.input,
        rules.confidence.input,
        rules.measured.input,
        rules.sensitivity.input,
        rules.processors.input,
        rules.planning.input,
        rules.leaning_walls.input,
        rules.edges.input,
        rules.starts.input,
        rules.fresh_paper.output,
