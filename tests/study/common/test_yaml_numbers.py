"""A config means the same to Snakemake's YAML reader and to ours."""

import yaml
from study.common.yaml_numbers import with_numbers

from scalar.data.io.plain_yaml import load_yaml

TEXT = "size: 1e-4\nnested: [{bound: 2E3}, 1.0e-4, 7]\nname: e4\nmeasured: {folder: null}\nswitch: true\n"


def test_numbers_are_read_as_our_reader_reads_them(tmp_path):
    """1e-4, which Snakemake's PyYAML reads as text, becomes a number, and all other values stay as they are."""
    (tmp_path / "config.yaml").write_text(TEXT)
    theirs = yaml.safe_load(TEXT)
    assert theirs["size"] == "1e-4"
    assert with_numbers(theirs) == load_yaml(tmp_path / "config.yaml")
