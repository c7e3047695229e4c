"""Write the tables and numbers of the worked example."""

from job import logged

with logged(snakemake.log):
    from pathlib import Path

    from scalar.data.io.atomic import write_json
    from study.common.tables import write_table
    from study.worked_example.tables import diagnosis_tables, errors, numbers, read

    given = snakemake.input
    truth, control_truth = Path(given.workcell) / "truth", Path(given.control_workcell) / "truth"
    diagnosed = Path(given.diagnosis).parent
    tables = diagnosis_tables(Path(given.workcell) / "dataset", diagnosed)
    found = errors(diagnosed, Path(given.control), truth, control_truth)
    for name, table in {**tables, "errors": found}.items():
        write_table(snakemake.output[name], table)
    content = numbers(read(given.diagnosis), read(truth / "truth.json"), found, tables)
    write_json(snakemake.output.numbers, content)
