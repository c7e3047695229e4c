"""Match the files that the user gives with the files that a mapping names."""

import os
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path, PurePath

from scalar.errors import Fault, InvalidInput
from scalar.ingest.mapping import FileRule, MappingFile


def _is_named(path: Path, name: str) -> bool:
    """Return whether a path is what a mapping names; a name with folders is compared with the last folders of the path too."""
    parts = name.count("/") + 1
    given = "/".join(path.absolute().parts[-parts:])
    return fnmatchcase(unicodedata.normalize("NFC", given), unicodedata.normalize("NFC", name))


def _in_folders(source: Path, name: str) -> list[Path]:
    """Return the files in folders of a source that a name with folders, such as ``day 2/scan_*.csv``, states; no folder outside of the source."""
    parts = PurePath(name).parts
    if len(parts) < 2 or PurePath(name).is_absolute() or ".." in parts:
        return []
    return [path for path in source.glob(name) if path.is_file()]


def _not_among_sources(name: str) -> str:
    """Return what to do about a name, or a pattern, of a mapping that fits no file among the sources."""
    alone = PurePath(name).name
    where = "folders inside a source are not searched"
    if alone and alone != name:
        where = f"the folder that the name begins with has to lie in it; or write {alone}, and give the folder that holds it as a source"
    if any(sign in name for sign in "*?["):
        return f"names these files, but none is among the sources; give them, or their folder ({where})"
    return f"names this file, but it is not among the sources; give it, or its folder ({where})"


def in_order_of_numbers(paths: Iterable[Path]) -> list[Path]:
    """Return paths folder by folder, in each by name, with numbers in names by their size: ``scan 2`` stands before ``scan 10``.

    Folders keep the order in which they are given first.
    """
    paths = list(paths)
    folders = list(dict.fromkeys(path.parent for path in paths))

    def key(path: Path) -> tuple[int, list[str | int], str]:
        parts = re.split("([0-9]+)", path.name.casefold())
        return folders.index(path.parent), [int(p) if k % 2 else p for k, p in enumerate(parts)], path.name

    return sorted(paths, key=key)


def distinct_names(paths: Sequence[Path], sources: Mapping[Path, Path]) -> list[str]:
    """Return what messages call each of several files, no two of which are called alike.

    A file of a folder that is a source has its path in that folder, and one that was given alone its name. If several are called so, they have
    the folders before it that distinguish them.

    Args:
        paths: The files, each once.
        sources: ``{file: the folder that was given and has it}``, without files that were given alone.
    """
    parts = [path.absolute().parts for path in paths]
    names = [path.relative_to(sources[path]).as_posix() if path in sources else path.name for path in paths]
    for depth in range(2, max(map(len, parts), default=0) + 1):
        shared = {name for name, times in Counter(names).items() if times > 1}
        names = [
            "/".join(own[-max(depth, name.count("/") + 1) :]) if name in shared else name
            for own, name in zip(parts, names, strict=True)
        ]
    return names


def choose_files(
    mapping: MappingFile, sources: Sequence[Path], file: str
) -> tuple[list[tuple[Path, FileRule]], ...]:
    """Return the files of the poses, of the points and of the nests, each file with its rule, in the order of the mapping.

    The name in a rule is what messages call this file. Files that one pattern names follow each other in the order of the numbers in their names,
    which is that of their acquisition.

    Args:
        mapping: The mapping; if it names no files, all files given are files of poses.
        sources: Files, or folders with the files that the mapping names; other files of a folder are ignored.
        file: Name of the mapping file, for messages.

    Raises:
        InvalidInput: A file that the mapping names is not given, a file is given that the mapping does not name, or a folder is given and the mapping
            names no files.
    """
    every = (mapping.poses, mapping.points, mapping.nests)
    rules = [rule for block in every if block is not None for rule in block.files]
    faults: list[Fault] = []
    given, called = _given_files(sources, rules, file, faults)
    if not rules:
        if faults:
            raise InvalidInput(faults)
        return [(path, FileRule(called[path], {}, {})) for path in given], [], []
    chosen: tuple[list[tuple[Path, FileRule]], ...] = ([], [], [])
    used: set[Path] = set()
    for block, found in zip(every, chosen, strict=True):
        if block is None:
            continue
        taken: set[Path] = set()
        for rule in block.files:
            matching = [path for path in given if _is_named(path, rule.name) and path not in taken]
            if not matching:
                faults.append(Fault(rule.name, f"{file} {_not_among_sources(rule.name)}"))
            found += [(path, replace(rule, name=called[path])) for path in in_order_of_numbers(matching)]
            taken.update(matching)
        used |= taken
    for path in given:
        if path not in used:
            names = ", ".join(rule.name for rule in rules)
            message = f"{file} has no such file, only {names}; add it to files, or leave it out"
            faults.append(Fault(str(path), message))
    if faults:
        raise InvalidInput(faults)
    return chosen


def _given_files(
    sources: Sequence[Path], rules: Sequence[FileRule], file: str, faults: list[Fault]
) -> tuple[list[Path], dict[Path, str]]:
    """Return the files among the sources, each once, and what messages call each of them.

    Args:
        sources: Files, or folders, of which the files that a rule names are taken.
        rules: All rules of the mapping.
        file: Name of the mapping file, for messages.
        faults: A fault is added for each folder if there are no rules.
    """
    given: list[Path] = []
    folders: dict[Path, Path] = {}
    for source in sources:
        if not source.is_dir():
            given.append(source)
        elif not rules:
            message = f"a folder, and {file} names no files; give the files themselves, or add poses.files"
            faults.append(Fault(str(source), message))
        else:
            inside = [path for path in source.iterdir() if path.is_file()]
            inside += [path for rule in rules for path in _in_folders(source, rule.name)]
            named = [path for path in inside if any(_is_named(path, rule.name) for rule in rules)]
            for path in in_order_of_numbers(dict.fromkeys(named)):
                folders.setdefault(path, source)
                given.append(path)
    first_given: dict[Path, Path] = {}  # a file that two sources hold is one file
    for path in given:
        first_given.setdefault(Path(os.path.realpath(path)), path)
    given = list(first_given.values())
    return given, dict(zip(given, distinct_names(given, folders), strict=True))
