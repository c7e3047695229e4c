# Former names of targets, which scripts may still use: each asks for what the rule of its present name makes.
localrules:
    closed_loop,
    summarise_closed_loop,
    draw_closed_loop,
    draw_committed_closed_loop,
    foretell_first_loop,
    close_first_loop,
    draw_first_loop,
    example_floor,
    tell_example,


rule closed_loop:
    input:
        rules.blind_trials.input,


rule summarise_closed_loop:
    input:
        rules.summarise_blind_trials.output,


rule draw_closed_loop:
    input:
        rules.draw_blind_trials.output,


rule draw_committed_closed_loop:
    input:
        rules.draw_committed_blind_trials.output,


rule foretell_first_loop:
    input:
        rules.predict_published_curves.output,


rule close_first_loop:
    input:
        rules.explain_published_curves.output,


rule draw_first_loop:
    input:
        rules.draw_published_curves.output,


rule example_floor:
    input:
        rules.example_control.output,


rule tell_example:
    input:
        rules.tabulate_example.output,
