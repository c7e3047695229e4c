rule simulate:
    input:
        scene=lambda w: local(scene_path(w)),
        robot=lambda w: robot_of_scene(scene_path(w)),
        modules=modules("study.headline.simulate"),
    output:
        directory(f"{RESULTS}/{{study}}/data/{{case}}/{{batch}}"),
    log:
        f"{RESULTS}/logs/simulate/{{study}}/{{case}}/{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/simulate/{{study}}/{{case}}/{{batch}}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    params:
        overrides=lambda w: CASES[w.study][w.case].overrides,
        seeds=lambda w: batch_seeds(w.batch),
    message:
        "Simulating {wildcards.study} {wildcards.case}, {wildcards.batch}"
    script:
        "../scripts/simulate_seeds.py"
