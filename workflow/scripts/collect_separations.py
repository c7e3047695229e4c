"""Join the confounded pairs of all sets, and count how many the further poses separate."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.provenance import code_version
    from study.common.tables import read_tables, write_table
    from study.planning.separation_summary import separation_numbers

    pairs = read_tables(snakemake.input.tables)
    write_table(snakemake.output.pairs, pairs)
    numbers = {"further_poses": snakemake.params.further} | separation_numbers(pairs)
    write_json(snakemake.output.numbers, {"code": code_version()} | numbers)
