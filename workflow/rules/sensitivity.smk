# Which answers depend on each setting of the diagnosis, halved and doubled on blind sets. A target of its own, `snakemake sensitivity`, an hour or two; a run that was stopped goes on with the set where it was. Its summaries are committed:
#   cp results/sensitivity/summaries/* paper/summaries/sensitivity/
from study.sensitivity.sets import load_sets

try:
    SENSITIVITY_CONFIG = named(config.get("sensitivity", "configs/sensitivity.yaml"))
    SENSITIVITY = load_sets(SENSITIVITY_CONFIG)
except InvalidInput as error:
    raise WorkflowError(str(error)) from None
SENSITIVITY_DIR = f"{RESULTS}/sensitivity"
SENSITIVITY_SET = f"{SENSITIVITY_DIR}/sets/{{blind_set}}.csv"


wildcard_constraints:
    blind_set="|".join(SENSITIVITY.sets),


localrules:
    sensitivity,


rule screen_settings:
    input:
        sets=expand(SENSITIVITY_SET, blind_set=SENSITIVITY.screened),
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
        SENSITIVITY_SET,
    log:
        f"{RESULTS}/logs/sensitivity/{{blind_set}}.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        config=local(SENSITIVITY_CONFIG),
        root=local(ROOT),
        # So that an edit of the config runs again what it changes, and nothing else.
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
        sets=expand(SENSITIVITY_SET, blind_set=SENSITIVITY.sets),
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
