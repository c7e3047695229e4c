"""Tabulate how far the headline's results differ between processors."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.provenance import code_version
    from study.common.tables import read_table, write_table
    from study.processors.compare import compare_processors, processor_numbers

    tables = dict(zip(snakemake.params.names, map(read_table, snakemake.input.tables), strict=True))
    compared = compare_processors(tables)
    write_table(snakemake.output.table, compared)
    write_json(snakemake.output.numbers, {"code": code_version()} | processor_numbers(tables, compared))
