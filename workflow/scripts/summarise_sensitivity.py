"""Tabulate which answers depend on each setting."""

from job import logged

with logged(snakemake.log):
    import pandas as pd
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_tables, write_table
    from study.sensitivity.summary import numbers, tabulate

    rows = read_tables(snakemake.input.sets).fillna({"changed": "", "example": ""})
    table = tabulate(rows, pd.read_csv(snakemake.input.guards, keep_default_na=False))
    write_table(snakemake.output.table, table, digits=4)
    write_json(snakemake.output.numbers, numbers(table, rows))
