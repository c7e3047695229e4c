# The paper: its numbers and figures from the results, its text from paper/. A part of the results that a config does
# not ask for is left out, section and all, and the title says that it is a draft.
PAPER = ROOT / "paper"
PAPER_NUMBERS = {"headline": f"{HEADLINE}/numbers.json"}  # {part: file whose leaves the text quotes}
PAPER_FIGURES = {  # {as the text calls it: file}
    "headline/errors.svg": f"{HEADLINE}/figures/errors.svg",
    "headline/parameters.svg": f"{HEADLINE}/figures/parameters_manifold.svg",
    "headline/singular_values.svg": f"{HEADLINE}/figures/singular_values_{next(iter(CASES['headline']))}.svg",
}

if "sequential" in config:
    PAPER_NUMBERS["sequential"] = f"{SEQUENTIAL_DIR}/numbers.json"
    PAPER_FIGURES["sequential/sequential.svg"] = f"{SEQUENTIAL_DIR}/figures/sequential.svg"


# What takes hours, or files that are not ours, is committed as small summaries; figures are drawn from them here.
LOOP_SUMMARIES = PAPER / "summaries/closed_loop"
if (LOOP_SUMMARIES / "numbers.json").exists():
    PAPER_NUMBERS["closed_loop"] = local(LOOP_SUMMARIES / "numbers.json")
    for name in LOOP_FIGURES:
        PAPER_FIGURES[f"closed_loop/{name}.svg"] = f"{RESULTS}/paper/closed_loop/{name}.svg"


use rule draw_closed_loop as draw_committed_closed_loop with:
    input:
        summaries=[local(LOOP_SUMMARIES / f"{name}.csv") for name in LOOP_TABLES],
        modules=modules("scalar.plots.closed_loop", "scalar.study.tables"),
    output:
        **{
            f"{name}_{suffix}": f"{RESULTS}/paper/closed_loop/{name}.{suffix}"
            for name in LOOP_FIGURES
            for suffix in ("png", "svg")
        },
    log:
        f"{RESULTS}/logs/paper/draw_closed_loop.log",
    message:
        "Drawing the closed loop from its committed summaries"


rule gather_numbers:
    input:
        parts=list(PAPER_NUMBERS.values()),
        scene=local(ROOT / STUDIES["headline"]["scene"]),
        tilted=local(ROOT / "configs/scenes/paper_tilted.yaml"),
        headline=resource("published_headline.csv"),
        planes=resource("published_plane_errors.csv"),
        curves=resource("published_curves.csv"),
        modules=modules("scalar.study.paper_numbers", "scalar.study.paper_parts", "scalar.study.tables"),
    output:
        f"{RESULTS}/paper/numbers.json",
    log:
        f"{RESULTS}/logs/paper/gather_numbers.log",
    threads: 1
    params:
        parts=PAPER_NUMBERS,
        seeds=STUDIES["headline"]["seeds"],
        draft=config.get("paper", {}).get("draft", False),
    message:
        "Gathering the paper's numbers"
    script:
        "../scripts/gather_numbers.py"


rule paper:
    input:
        numbers=rules.gather_numbers.output[0],
        text=[local(path) for path in sorted(PAPER.rglob("*")) if path.suffix in (".typ", ".bib")],
        figures=list(PAPER_FIGURES.values()),
        modules=modules("scalar.study.paper"),
    output:
        report(
            f"{RESULTS}/paper.pdf",
            caption="../report/paper.rst",
            category="Paper",
            labels={"shows": "the paper"},
        ),
    log:
        f"{RESULTS}/logs/paper/paper.log",
    threads: 1
    params:
        text=local(PAPER),
        figures=PAPER_FIGURES,
    message:
        "Typesetting the paper"
    script:
        "../scripts/build_paper.py"
