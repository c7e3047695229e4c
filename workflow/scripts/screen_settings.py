"""Choose the settings that are varied on the other blind sets too, by the results on the sets of the screening."""

from job import logged

with logged(snakemake.log):
    from scalar.data.io.atomic import write_json
    from study.common.tables import read_tables
    from study.sensitivity.summary import still_open

    write_json(snakemake.output[0], still_open(read_tables(snakemake.input.sets).fillna({"changed": ""})))
