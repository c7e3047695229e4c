"""The workflow as others use it: found by the Snakemake workflow catalogue, deployed from afar, its software stated."""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from git import Repo
from ruamel.yaml import YAML

from tests.checkouts import copy_checkout

ROOT = Path(__file__).parents[1]
OWNER = "github.com/someone/scalar"


def run(folder: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Return a finished run of snakemake in a folder, stdout and stderr as one text."""
    return subprocess.run(
        [sys.executable, "-m", "snakemake", "--nocolor", *arguments],
        cwd=folder,
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_snakemake_finds_nothing_to_complain_about():
    """`snakemake --lint` is silent: each rule has a log and an environment, and no file holds rules and functions."""
    ran = run(ROOT, "--lint")
    assert ran.returncode == 0, ran.stdout


def test_the_environment_of_a_job_is_the_locked_one():
    """workflow/envs/scalar.yaml holds what pyproject.toml asks for, in the versions of the lock; `make lock` writes it."""
    path = ROOT / "workflow/envs/write_environment.py"
    spec = importlib.util.spec_from_file_location("write_environment", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    text = (ROOT / "workflow/envs/scalar.yaml").read_text(encoding="utf-8")
    assert text == module.environment(ROOT)
    packages = YAML(typ="safe").load(text)["dependencies"][-1]["pip"]
    assert {"numpy", "pybullet", "snakemake", "typst"} <= {name.split("==")[0] for name in packages}


def test_the_catalogue_finds_what_it_needs():
    """The repository has the catalogue's file, a Snakefile in workflow/, and a config/ whose README explains every key."""
    usage = YAML(typ="safe").load((ROOT / ".snakemake-workflow-catalog.yml").read_text("utf-8"))["usage"]
    assert usage["software-stack-deployment"]["conda"] is True
    assert usage["mandatory-flags"]["flags"] == "--sdm conda"
    assert (ROOT / "workflow/Snakefile").is_file() and (ROOT / "config/config.yaml").is_file()
    schema = json.loads((ROOT / "workflow/schemas/config.schema.json").read_text(encoding="utf-8"))
    readme = (ROOT / "config/README.md").read_text(encoding="utf-8")
    explained = re.findall(r"`(\w+)`", "".join(re.findall(r"(?m)^\| (`.+?`) \|", readme)))
    assert set(explained) == set(schema["properties"])


@pytest.fixture
def deployed(tmp_path: Path) -> tuple[Path, dict[str, str]]:
    """Return a folder as `snakedeploy` makes it, and the environment in which its repository is in Snakemake's cache.

    The repository is a commit of this checkout as it stands. A commit that is in the cache is not fetched again.
    """
    repository = tmp_path / "repository"
    shutil.copytree(ROOT / "config", copy_checkout(repository) / "config")
    made = Repo.init(repository)
    made.git.add(all=True)
    made.git.execute(
        ["git", "-c", "user.name=test", "-c", "user.email=test@example.org", "commit", "-qm", "all"]
    )
    home = tmp_path / "home"
    cache = home / "snakemake/snakemake/source-cache/snakemake-git-cache" / OWNER
    cache.parent.mkdir(parents=True)
    made.clone(str(cache), bare=True)
    user = tmp_path / "user"
    (user / "workflow").mkdir(parents=True)
    shutil.copytree(ROOT / "config", user / "config")
    commit = made.head.commit.hexsha
    (user / "workflow/Snakefile").write_text(
        'configfile: "config/config.yaml"\n\nmodule scalar:\n'
        f'    snakefile: github("someone/scalar", path="workflow/Snakefile", commit="{commit}")\n'
        "    config: config\n\nuse rule * from scalar\n",
        encoding="utf-8",
    )
    return user, {"XDG_CACHE_HOME": str(home)}


@pytest.mark.slow
def test_the_workflow_is_deployed_from_afar(deployed):
    """A folder with a Snakefile of five lines runs it, with scenes and grids of its own, from a checkout that it gets by itself."""
    folder, environment = deployed
    (folder / "configs/grids").mkdir(parents=True)
    (folder / "configs/grids/headline.csv").write_text("case,poses_per_plane\nof-my-own,14\n", "utf-8")
    ran = run(folder, "--dry-run", "--cores", "1", **environment)
    assert ran.returncode == 0, ran.stdout
    assert "headline/data/of-my-own/seeds-001-005" in ran.stdout
    (checkout,) = (folder / ".snakemake/scalar").iterdir()
    assert (checkout / "scalar/__init__.py").exists()
