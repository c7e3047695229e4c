"""Whether the tables are what dataset.yaml says of them: their columns, rows, units and signs."""
