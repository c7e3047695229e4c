"""Files: atomic writes, CSV, Parquet and plain YAML."""
