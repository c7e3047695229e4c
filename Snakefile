# simulate -> calibrate -> evaluate -> figures, over seeds and cases.
#
#   snakemake --cores 2                                      everything in configs/paper.yaml
#   snakemake --cores 2 --configfile configs/smoke.yaml      every rule, small
#   snakemake figures --cores 2                              figures only, from the tables
#   snakemake measured --cores 2                             measured robots, where their files are to be had
#   snakemake blind_trials --cores 2                          what a diagnosis makes of injected effects: about an hour
#   snakemake blind_trials_stratified --cores 2               imperfect scanners, surfaces, many effects crossed: hours
#   snakemake confidence --cores 2                           how sure answers may be, fitted and reported: about an hour
#   snakemake sensitivity --cores 2                          what depends on each setting of the diagnosis: about an hour
#   snakemake processors --cores 2                           which figures of the headline depend on the processor
#   snakemake --report report.html                           a page with all results, after a run
from snakemake.utils import min_version

min_version("9.20")

if not workflow.config_settings.configfiles:  # a --configfile replaces the default, whole

    configfile: os.path.join(workflow.basedir, "configs/paper.yaml")


report: "workflow/report/workflow.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/simulate.smk"
include: "workflow/rules/calibrate.smk"
include: "workflow/rules/evaluate.smk"
include: "workflow/rules/sweeps.smk"
include: "workflow/rules/sequential.smk"
include: "workflow/rules/scene_figures.smk"
include: "workflow/rules/published_curves.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/measured.smk"
include: "workflow/rules/processors.smk"
include: "workflow/rules/blind_trials.smk"
include: "workflow/rules/confidence.smk"
include: "workflow/rules/sensitivity.smk"
include: "workflow/rules/worked_example.smk"
include: "workflow/rules/claims.smk"
include: "workflow/rules/paper.smk"
include: "workflow/rules/aliases.smk"


localrules:
    all,
    figures,
    measured,


rule all:
    default_target: True
    input:
        rules.figures.input,
        rules.summarise_headline.output,
        SWEEP_NUMBERS,
        SEQUENTIAL_TABLES,
        CLAIMS_TABLES,
        WORKED_EXAMPLE,
        PUBLISHED_CURVES_TABLES,
        rules.paper.output,
