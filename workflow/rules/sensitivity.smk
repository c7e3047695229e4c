# Which answers depend on each setting of the diagnosis: every setting is halved and doubled on blind sets. Not part of the default target:
# `snakemake sensitivity` takes an hour or two, and goes on with the sets that are left if it was stopped. The summaries are committed:
#   cp results/sensitivity/summaries/* paper/summaries/sensitivity/
from study.sensitivity.sets import load_sets

try:
    SENSITIVITY_CONFIG = config_path(config.get("sensitivity", "configs/sensitivity.yaml"))
    SENSITIVITY = load_sets(SENSITIVITY_CONFIG)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None
SENSITIVITY_DIR = f"{RESULTS}/sensitivity"
SENSITIVITY_ROWS = f"{SENSITIVITY_DIR}/sets/{{blind_set}}.csv"


wildcard_constraints:
    blind_set="|".join(SENSITIVITY.sets),


localrules:
    sensitivity,


rule screen_settings:
    input:
        sets=expand(SENSITIVITY_ROWS, blind_set=SENSITIVITY.screened),
        modules=modules("study.sensitivity.summary", "study.common.tables"),
    output:
        f"{SENSITIVITY_DIR}/screened.json",
    log:
        f"{RESULTS}/logs/sensitivity/screen.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Choosing the settings that are varied on the other blind sets"
    script:
        "../scripts/screen_settings.py"


rule vary_settings:
    input:
        unpack(
            lambda w: (
                {}
                if w.blind_set in SENSITIVITY.screened
                else {"screened": f"{SENSITIVITY_DIR}/screened.json"}
            )
        ),
        scene=lambda w: files_of_scene(
            ROOT / SENSITIVITY.workcells[SENSITIVITY.sets[w.blind_set].workcell]["scene"]
        ),
        modules=modules("study.sensitivity.vary", "study.sensitivity.datasets", "study.common.tables"),
    output:
        SENSITIVITY_ROWS,
    log:
        f"{RESULTS}/logs/sensitivity/{{blind_set}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(SENSITIVITY_CONFIG),
        root=local(ROOT),
        # What the config says of the set, so that an edit of the config runs again only the sets that it changes.
        wanted=lambda w: repr(
            (
                SENSITIVITY.scene,
                SENSITIVITY.workcells[SENSITIVITY.sets[w.blind_set].workcell],
                SENSITIVITY.sets[w.blind_set],
            )
        ),
    message:
        "Varying the settings on {wildcards.blind_set}"
    script:
        "../scripts/vary_settings.py"


rule summarise_sensitivity:
    input:
        sets=expand(SENSITIVITY_ROWS, blind_set=SENSITIVITY.sets),
        guards=resource("guarding_settings.csv"),
        modules=modules("study.sensitivity.summary", "study.common.tables"),
    output:
        table=report(
            f"{SENSITIVITY_DIR}/summaries/settings.csv",
            caption="../report/sensitivity.rst",
            category="Tables",
            labels={"study": "sensitivity", "shows": "which answers depend on each setting"},
        ),
        numbers=f"{SENSITIVITY_DIR}/summaries/numbers.json",
    log:
        f"{RESULTS}/logs/sensitivity/summarise.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Tabulating which answers depend on each setting"
    script:
        "../scripts/summarise_sensitivity.py"


rule draw_sensitivity:
    input:
        table=f"{SENSITIVITY_DIR}/summaries/settings.csv",
        modules=modules("study.plots.sensitivity", "study.common.tables"),
    output:
        **figure(
            f"{SENSITIVITY_DIR}/figures/sensitivity", "figure_sensitivity", "Sensitivity", shows="settings"
        ),
    log:
        f"{RESULTS}/logs/sensitivity/draw.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Drawing which answers depend on each setting"
    script:
        "../scripts/draw_sensitivity.py"


rule sensitivity:
    input:
        rules.summarise_sensitivity.output,
        rules.draw_sensitivity.output,
