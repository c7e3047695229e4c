# The workflow stands in workflow/Snakefile. With this file, `snakemake --cores 2` finds it from the root of a clone.
include: "workflow/Snakefile"


workflow.default_target = "all"  # an included file cannot say so itself
