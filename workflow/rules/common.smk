# Checks of the config, and what the rules look up: cases, batches of seeds, the modules a step depends on.
import ast
import sys
from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import validate

ROOT = Path(workflow.basedir)
sys.path[:0] = [str(ROOT), str(ROOT / "workflow")]
# Jobs import the checkout that the Snakefile stands in. One thread a job for BLAS: the same bytes on any number
# of cores, and two jobs do not fight for two cores.
os.environ["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(ROOT), str(ROOT / "workflow"), os.environ.get("PYTHONPATH")])
)
for library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR"):
    os.environ[f"{library}_NUM_THREADS"] = "1"

from scalar.errors import InvalidInput
from study.common.grid import read_grid
from study.common.methods import METHODS, PROPOSED
from study.common.renamed import renamed_faults
from study.common.schema_faults import schema_faults
from study.common.seeds import batch_names, batch_seeds
from scalar.data.io.plain_yaml import load_yaml, resolve


def with_numbers(value):
    """Return a config with 1e-4 as a number: Snakemake's own YAML reader takes it for text."""
    if isinstance(value, dict):
        return {key: with_numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [with_numbers(item) for item in value]
    number = resolve(value) if isinstance(value, str) else value
    return number if isinstance(number, float) else value


def checked_grids(studies):
    """Return {study: {case: Case}}; a misspelt column or a bad cell stops the workflow, named."""
    try:
        return {
            name: {case.name: case for case in read_grid(ROOT / study["grid"])}
            for name, study in studies.items()
        }
    except InvalidInput as error:
        raise WorkflowError(str(error)) from None


def local(path):
    """Return a file of the repository as jobs name it: short where the repository is the working directory."""
    here = Path.cwd()
    return str(path.relative_to(here) if path.is_relative_to(here) else path)


def scene_file(wildcards):
    """Return the scene that a case starts from."""
    return local(ROOT / (CASES[wildcards.study][wildcards.case].scene or STUDIES[wildcards.study]["scene"]))


def robot_file(wildcards):
    """Return the robot file of a case's scene; nothing where the scene holds the robot itself."""
    scene = Path(scene_file(wildcards))
    robot = load_yaml(scene).get("robot")
    return [local((ROOT / scene.parent / robot).resolve())] if isinstance(robot, str) else []


def batches(study):
    """Return the names of the batches of seeds of a study."""
    return batch_names(config["first_seed"], STUDIES[study]["seeds"], config["seeds_per_job"])


def evaluations(table):
    """Return an input function: this table of every case and batch of a study."""
    return lambda wildcards: expand(
        f"{RESULTS}/{wildcards.study}/evaluations/{{case}}/{{batch}}/{table}.csv",
        case=CASES[wildcards.study],
        batch=batches(wildcards.study),
    )


def resource(name):
    """Return a file of published values."""
    return local(ROOT / "workflow/resources" / name)


def figure(name, caption, category, **labels):
    """Return a figure's outputs, PNG (in the report) and SVG."""
    return {
        "png": report(f"{name}.png", caption=f"../report/{caption}.rst", category=category, labels=labels),
        "svg": f"{name}.svg",
    }


OUR_PACKAGES = ("scalar", "study")


@cache
def imports(name):
    """Return the files that a module of ours is, and the names that it imports; nothing for a name inside a module.

    Kept: every rule asks, and to parse a file is slow.
    """
    home = ROOT / "workflow" if name.split(".")[0] == "study" else ROOT
    path = home / name.replace(".", "/")
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    if not path.exists():
        return (), ()
    parts = name.split(".")
    names = {".".join(parts[:i]) for i in range(1, len(parts))}
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names if alias.name.startswith(OUR_PACKAGES))
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith(OUR_PACKAGES):
            names.update([node.module, *(f"{node.module}.{alias.name}" for alias in node.names)])
    return tuple(map(local, [path, *path.parent.glob("schemas/*.json")])), tuple(names)


def modules(*names):
    """Return the source files that modules of scalar and of the study import, directly or not, and the schemas beside them.

    Snakemake does not see that a script's imports changed: a rule lists them as input. Found by reading the
    import statements, those inside functions too, so that the list cannot drift.
    """
    waiting, seen, found = list(names), set(), set()
    while waiting:
        name = waiting.pop()
        if name not in seen:
            seen.add(name)
            files, imported = imports(name)
            found.update(files)
            waiting += imported
    return sorted(found)


config.update(with_numbers(config))
if faults := renamed_faults(config) or schema_faults(config, ROOT / "workflow/schemas/config.schema.json"):
    raise WorkflowError("\n".join(faults))
validate(config, str(ROOT / "workflow/schemas/config.schema.json"))
RESULTS = config["results"]
STUDIES = config["studies"]
CASES = checked_grids(STUDIES)
HEADLINE = f"{RESULTS}/headline"


wildcard_constraints:
    set=r"[a-z0-9_]+",
    study="|".join(STUDIES),
    case=r"[A-Za-z0-9][A-Za-z0-9_.-]*",
    method="|".join(METHODS),
    batch=r"seeds-\d+-\d+",
