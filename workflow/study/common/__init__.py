"""What several studies share: grids of cases, seeds, tables, methods, statistics over the seeds, the Cramér-Rao bound, the version of the code."""
