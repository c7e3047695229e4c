"""Write a finished run as an RO-Crate: one zip that states in JSON-LD what made each file (RO-Crate 1.1, profile Workflow RO-Crate 1.0).

The archive contains the workflow with its rules and scripts, the config of the run, and the results: figures, tables and the paper. The simulated
datasets are left out, since the same seeds produce them again, byte by byte.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rocrate.model.person import Person
from rocrate.rocrate import ROCrate

from scalar.data.io.atomic import atomic_write
from scalar.data.io.plain_yaml import load_yaml

WORKFLOW = "workflow/Snakefile"
LICENCES = {"MIT": "https://spdx.org/licenses/MIT"}
MEDIA = {
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".csv": "text/csv",
    ".json": "application/json",
    ".pdf": "application/pdf",
    ".html": "text/html",
}


def write_crate(path: Path, *, root: Path, results: Sequence[Path], config: Mapping[str, Any]) -> None:
    """Write the RO-Crate of a run, whole or not at all.

    Args:
        path: The zip to write.
        root: Folder of the checkout.
        results: Files that the run made, at least one; paths are absolute or relative to the working directory.
        config: Config of the run.

    Raises:
        FileNotFoundError: A result is missing.
        InvalidInput: CITATION.cff cannot be read.
        KeyError: The ending of a result is not in ``MEDIA``, or the licence not in ``LICENCES``.
    """
    citation = load_yaml(root / "CITATION.cff")
    # Any: the type hints of rocrate do not know the attributes of an entity.
    crate: Any = ROCrate(version="1.1")
    crate.name = f"A run of {citation['title']}"
    crate.description = (
        "Figures, tables and paper of one run, with the workflow and the config that made them."
    )
    crate.license = LICENCES[citation["license"]]
    finished = max(file.stat().st_mtime for file in results)
    crate.datePublished = datetime.fromtimestamp(finished, UTC)
    authors = [
        crate.add(Person(crate, f"#author-{number}", {"name": author["name"]}))
        for number, author in enumerate(citation["authors"], start=1)
    ]
    crate.creator = authors
    # This call also states the profile, Workflow RO-Crate.
    workflow: Any = crate.add_workflow(
        root / WORKFLOW, WORKFLOW, main=True, lang="snakemake", lang_version=version("snakemake")
    )
    workflow["name"] = citation["title"]
    workflow["version"] = str(citation["version"])
    workflow["license"] = crate.license
    workflow["creator"] = authors
    if commit := _commit(root):
        workflow["identifier"] = commit
    for file in _sources(root):
        crate.add_file(file, file.relative_to(root).as_posix())
    with tempfile.TemporaryDirectory() as folder:
        config_file = Path(folder, "config.json")
        config_file.write_text(json.dumps(config, indent=1) + "\n", encoding="utf-8")
        about = {"name": "the config of the run", "encodingFormat": MEDIA[".json"]}
        config_entity = crate.add_file(config_file, "config.json", properties=about)
        made = [
            crate.add_file(file, _within(file), properties={"encodingFormat": MEDIA[file.suffix]})
            for file in results
        ]
        about = {"name": "snakemake", "endTime": datetime.fromtimestamp(finished, UTC).isoformat()}
        crate.add_action(workflow, object=config_entity, result=made, properties=about)
        with atomic_write(path) as temporary:
            crate.write_zip(temporary)


def _sources(root: Path) -> list[Path]:
    """Return the files in ``workflow/`` except ``WORKFLOW``, and those of Snakefile, citation, licence and lock file that the checkout has."""
    of_workflow = [
        file
        for file in sorted((root / "workflow").rglob("*"))
        if file.is_file() and file.suffix != ".pyc" and file != root / WORKFLOW
    ]
    named = [root / name for name in ("Snakefile", "CITATION.cff", "LICENSE", "requirements/lock.txt")]
    return [*of_workflow, *filter(Path.exists, named)]


def _within(file: Path) -> str:
    """Return the path of a result in the archive: the same path if it is relative, ``results/NAME`` if it is absolute."""
    return file.as_posix() if not file.is_absolute() else f"results/{file.name}"


def _commit(root: Path) -> str | None:
    """Return the commit of a checkout; None outside a repository."""
    ran = subprocess.run(
        ["git", "-C", str(root), "rev-parse", "HEAD"], capture_output=True, text=True, check=False
    )
    return ran.stdout.strip() if ran.returncode == 0 else None
