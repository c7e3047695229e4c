# One diagnosis from scratch, by the command line: a workcell with a gear error that its dataset does not mention.
EXAMPLE = f"{RESULTS}/worked_example"
EXAMPLE_SCENE = "configs/scenes/worked_example.yaml"
WITH_CONDA = workflow.deployment_settings.deployment_method  # empty without --sdm
SCALAR = f"{'python' if WITH_CONDA else sys.executable} -m scalar.cli"


rule simulate_example:
    input:
        scene=local(ROOT / EXAMPLE_SCENE),
        robot=robot_of_scene(ROOT / EXAMPLE_SCENE),
        modules=modules("scalar.cli", "scalar.simulation"),
    output:
        directory(f"{EXAMPLE}/workcell"),
    log:
        f"{RESULTS}/logs/worked_example/simulate.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        scalar=SCALAR,
    shell:
        "{params.scalar} simulate {input.scene} -o {output} > {log} 2>&1"


rule diagnose_example:
    input:
        workcell=rules.simulate_example.output[0],
        modules=modules("scalar.cli", "scalar.diagnosis", "scalar.report"),
    output:
        before=f"{EXAMPLE}/before.json",
        after=f"{EXAMPLE}/after.json",
        diagnosis=f"{EXAMPLE}/diagnosis.json",
        page=report(
            f"{EXAMPLE}/report.html",
            caption="../report/worked_example_report.rst",
            category="Worked example",
            labels={"shows": "the diagnosis as a user gets it"},
        ),
    log:
        f"{RESULTS}/logs/worked_example/diagnose.log",
    conda:
        ENVIRONMENT
    threads: 1
    params:
        scalar=SCALAR,
        folder=subpath(output.page, parent=True),
    shell:
        "{params.scalar} diagnose {input.workcell}/dataset -o {params.folder} > {log} 2>&1"


rule example_control:
    input:
        scene=local(ROOT / EXAMPLE_SCENE),
        robot=rules.simulate_example.input.robot,
        modules=modules("study.worked_example.tables", "scalar.simulation"),
    output:
        workcell=directory(f"{EXAMPLE}/control"),
        calibration=f"{EXAMPLE}/control.json",
    log:
        f"{RESULTS}/logs/worked_example/control.log",
    conda:
        ENVIRONMENT
    threads: 1
    script:
        "../scripts/example_control.py"


rule tabulate_example:
    input:
        workcell=rules.simulate_example.output[0],
        diagnosis=rules.diagnose_example.output.diagnosis,
        before=rules.diagnose_example.output.before,
        after=rules.diagnose_example.output.after,
        control=rules.example_control.output.calibration,
        control_workcell=rules.example_control.output.workcell,
        modules=modules("study.worked_example.tables", "study.common.tables"),
    output:
        poses=f"{EXAMPLE}/poses.csv",
        curve=f"{EXAMPLE}/curve.csv",
        ranking=f"{EXAMPLE}/ranking.csv",
        errors=f"{EXAMPLE}/errors.csv",
        numbers=f"{EXAMPLE}/numbers.json",
    log:
        f"{RESULTS}/logs/worked_example/tabulate.log",
    conda:
        ENVIRONMENT
    threads: 1
    message:
        "Making the tables of the worked example"
    script:
        "../scripts/tabulate_example.py"


rule draw_example:
    input:
        poses=rules.tabulate_example.output.poses,
        curve=rules.tabulate_example.output.curve,
        ranking=rules.tabulate_example.output.ranking,
        errors=rules.tabulate_example.output.errors,
        numbers=rules.tabulate_example.output.numbers,
        modules=modules("study.plots.worked_example", "study.common.tables"),
    output:
        **figure(
            f"{EXAMPLE}/figures/worked_example",
            "figure_worked_example",
            "Worked example",
            shows="from residual to effect",
        ),
    log:
        f"{RESULTS}/logs/worked_example/draw.log",
    conda:
        ENVIRONMENT
    threads: 1
    script:
        "../scripts/draw_example.py"


WORKED_EXAMPLE = [
    *rules.draw_example.output,
    rules.tabulate_example.output.numbers,
    rules.diagnose_example.output.page,
]
