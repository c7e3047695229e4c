"""Write workflow/envs/scalar.yaml, the environment of `snakemake --sdm conda`: what jobs import, in the versions of requirements/lock.txt.

    python workflow/envs/write_environment.py    (`make lock` calls it)

The packages come by pip, so that conda's environment and that of `make env` hold the same builds.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
PYTHON = "3.11"  # the simulator has no wheels for later ones
EXTRAS = ("simulation", "workflow")  # of pyproject.toml, beside the dependencies that everyone has
HEAD = "# Written by `make lock` from pyproject.toml and requirements/lock.txt; used with snakemake --sdm conda.\n"


def environment(root: Path = ROOT) -> str:
    """Return the text of the environment file of a checkout."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"]]
    for extra in EXTRAS:
        wanted += project["optional-dependencies"][extra]
    names = sorted({canonicalize_name(Requirement(text).name) for text in wanted})
    lock = (root / "requirements/lock.txt").read_text(encoding="utf-8")
    locked = dict(re.findall(r"^([a-z0-9-]+)==([^\s;]+)", lock, re.MULTILINE))
    packages = "".join(f"      - {name}=={locked[name]}\n" for name in names)
    return (
        f"{HEAD}channels:\n  - conda-forge\n  - nodefaults\ndependencies:\n"
        f"  - python={PYTHON}\n  - pip\n  - pip:\n{packages}"
    )


if __name__ == "__main__":
    (ROOT / "workflow/envs/scalar.yaml").write_text(environment(), encoding="utf-8")
