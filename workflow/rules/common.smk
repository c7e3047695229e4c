# Checks of the config, and what the rules look up: cases, batches of seeds, the modules a step depends on.
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

from git import Repo
from snakemake.exceptions import WorkflowError
from snakemake.sourcecache import HostingProviderFile
from snakemake.utils import validate


def checkout(rules):
    """Return the root of the checkout that contains a folder of rules; for rules of a remote repository (`github(...)`), clone it below .snakemake."""
    if not isinstance(rules, HostingProviderFile):
        return Path(rules.get_path_or_uri(secret_free=True)).parents[1]
    repository = rules.hosted_repo.repo
    commit = repository.commit(rules.ref).hexsha
    folder = Path(".snakemake/scalar", commit).resolve()
    if not folder.exists():
        folder.parent.mkdir(parents=True, exist_ok=True)
        unfinished = tempfile.mkdtemp(dir=folder.parent)
        Repo.clone_from(repository.git_dir, unfinished, no_checkout=True).git.checkout(commit)
        Path(unfinished).rename(folder)
    return folder


ROOT = checkout(workflow.current_basedir)
ENVIRONMENT = str(ROOT / "workflow/envs/scalar.yaml")  # of every job, with --sdm conda
HOMES = {"scalar": ROOT, "study": ROOT / "workflow"}  # {package of this repository: folder it lies in}
sys.path[:0] = map(str, HOMES.values())

from scalar.errors import InvalidInput
from study.common.ended import end_when_asked
from study.common.grid import read_grid
from study.common.job_environment import job_environment
from study.common.job_files import files_of_scene, local, robot_of_scene
from study.common.methods import METHODS, PROPOSED
from study.common.renamed import renamed_faults
from study.common.schema_faults import schema_faults
from study.common.seeds import batch_names, batch_seeds
from study.common.sources import source_files
from study.common.take_over import WORKFLOW_PROCESS, take_over
from study.common.yaml_numbers import with_numbers

# Jobs import the checkout that the Snakefile stands in, and end with the Snakemake that started them.
os.environ.update(job_environment(list(HOMES.values()), os.environ))
os.environ[WORKFLOW_PROCESS] = str(os.getpid())
if workflow.is_main_process:  # not in the process of a job
    with suppress(OSError):
        take_over(Path(".snakemake").absolute())


def config_path(path):
    """Return the path of a file that the config names: in the working directory if the file exists there, else in the checkout."""
    return Path(path).resolve() if Path(path).exists() else ROOT / path


def checked_grids(studies):
    """Return {study: {case: Case}}; a misspelt column or a bad cell stops the workflow with a message that names it."""
    try:
        return {
            name: {case.name: case for case in read_grid(config_path(study["grid"]))}
            for name, study in studies.items()
        }
    except InvalidInput as error:
        raise WorkflowError(str(error)) from None


def scene_path(wildcards):
    """Return the scene that a case starts from."""
    return config_path(CASES[wildcards.study][wildcards.case].scene or STUDIES[wildcards.study]["scene"])


def batches(study):
    """Return the names of the batches of seeds of a study."""
    return batch_names(config["first_seed"], STUDIES[study]["seeds"], config["seeds_per_job"])


def case_of_figure(wildcards):
    """Return the case that a figure of the headline shows."""
    return CASE_OF_FIGURE[wildcards.case_suffix]


def evaluations(table):
    """Return an input function, which returns the files of a table of the evaluation (`errors`, `planes`, `parameters`) for all cases and batches of a study."""
    return lambda wildcards: expand(
        f"{RESULTS}/{wildcards.study}/evaluations/{{case}}/{{batch}}/{table}.csv",
        case=CASES[wildcards.study],
        batch=batches(wildcards.study),
    )


def resource(name):
    """Return the path of a file in workflow/resources, as jobs name it."""
    return local(ROOT / "workflow/resources" / name)


def figure(name, caption, category, **labels):
    """Return a figure's outputs, PNG (in the report) and SVG; a label may be a function of the wildcards."""

    def by_wildcards(wildcards):
        return {key: label(wildcards) if callable(label) else label for key, label in labels.items()}

    stated = by_wildcards if any(map(callable, labels.values())) else labels
    return {
        "png": report(f"{name}.png", caption=f"../report/{caption}.rst", category=category, labels=stated),
        "svg": f"{name}.svg",
    }


def modules(*names):
    """Return the source files that modules of scalar and of the study import, directly or not, and the schemas beside them."""
    return sorted(map(local, source_files(names, HOMES)))


config.update(with_numbers(config))
if faults := renamed_faults(config) or schema_faults(config, ROOT / "workflow/schemas/config.schema.json"):
    raise WorkflowError("\n".join(faults))
validate(config, str(ROOT / "workflow/schemas/config.schema.json"))
RESULTS = config["results"]
STUDIES = config["studies"]
CASES = checked_grids(STUDIES)
HEADLINE = f"{RESULTS}/headline"
FIRST_CASE = next(iter(CASES["headline"].values()))  # what the paper, its numbers and its claims are about
FURTHER_CASES = {f"_{name}": name for name in CASES["headline"] if name != FIRST_CASE.name}
CASE_OF_FIGURE = {
    "": FIRST_CASE.name,
    **FURTHER_CASES,
}  # {end of the name of a figure: the case that it shows}


wildcard_constraints:
    set=r"[a-z0-9_]+",
    study="|".join(STUDIES),
    case=r"[A-Za-z0-9][A-Za-z0-9_.-]*",
    method="|".join(METHODS),
    batch=r"seeds-\d+-\d+",
    case_suffix=f"({'|'.join(CASE_OF_FIGURE)})",
