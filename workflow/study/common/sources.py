"""Find the source files that a module imports, directly or not. Snakemake does not notice that a script's imports changed, so each rule lists them.

They are found by reading the import statements, also those inside functions, so that the list is never out of date; nothing is imported.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path


def source_files(names: Iterable[str], homes: Mapping[str, Path]) -> set[Path]:
    """Return the files of modules and of all that they import from this repository's packages, with the schemas and the C sources beside them.

    Args:
        names: Dotted names of modules.
        homes: ``{package of this repository: folder that contains it}``; imports of other packages are left out.
    """
    waiting, seen, found = list(names), set[str](), set[Path]()
    while waiting:
        name = waiting.pop()
        if name not in seen and (home := homes.get(name.split(".")[0])):
            seen.add(name)
            files, imported = _files_and_imports(name, home)
            found.update(files)
            waiting += imported
    return found


@cache
def _files_and_imports(name: str, home: Path) -> tuple[tuple[Path, ...], tuple[str, ...]]:
    """Return the files that a module consists of, and the names that it imports; nothing for a name inside a module.

    The answer is cached: every rule asks, and parsing a file is slow.
    """
    path = home / name.replace(".", "/")
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    if not path.exists():
        return (), ()
    parts = name.split(".")
    names = {".".join(parts[:i]) for i in range(1, len(parts))}
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update([node.module, *(f"{node.module}.{alias.name}" for alias in node.names)])
    return (path, *path.parent.glob("schemas/*.json"), *path.parent.glob("*.[ch]")), tuple(sorted(names))
