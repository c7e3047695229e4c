"""Join the rows of all axes, and summarise up to which degree the diagnosis holds."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.provenance import code_version
    from study.common.tables import read_tables, write_table
    from study.edges.summary import edge_numbers, summarise_edges

    rows = read_tables(snakemake.input.tables)
    summary = summarise_edges(rows)
    write_table(snakemake.output.edges, rows)
    write_table(snakemake.output.summary, summary)
    write_json(snakemake.output.numbers, {"code": code_version()} | edge_numbers(summary))
