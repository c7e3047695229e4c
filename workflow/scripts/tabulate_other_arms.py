"""Write which parameters three planes leave undetermined for the six-axis arms of the library."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    import numpy as np
    from scalar.data.io.atomic import write_json
    from scalar.geometry.se3 import exp_so3
    from scalar.simulation.config import load_config
    from study.common.tables import write_table
    from study.headline.other_arms import arms_numbers, arms_table

    scene = load_config(Path(snakemake.input.scene))
    pose, T = scene["sensor"]["pose"], np.eye(4)
    T[:3, 3], T[:3, :3] = pose["translation"], exp_so3(np.array(pose["rotation_vector"]))
    table = arms_table(T, scene["initial_model"]["exact"])
    write_table(snakemake.output.table, table)
    write_json(snakemake.output.numbers, arms_numbers(table))
