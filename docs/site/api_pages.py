"""The names of ``import scalar`` as a page: each with its docstring, functions before classes."""

from __future__ import annotations

import inspect
from pathlib import Path

import scalar

_PARTS = (
    ("Reading and calibrating", inspect.isfunction),
    ("Classes", lambda found: inspect.isclass(found) and not issubclass(found, Exception)),
    ("Errors", lambda found: inspect.isclass(found) and issubclass(found, Exception)),
)


def write_page(path: Path) -> None:
    """Write the documentation of every public name."""
    lines: list[str] = []
    for title, belongs in _PARTS:
        lines += [f"## {title}", ""]
        for name in scalar.__all__:
            found = getattr(scalar, name)
            if belongs(found):
                kind = "autofunction" if inspect.isfunction(found) else "autoclass"
                lines += ["```{eval-rst}", f".. {kind}:: scalar.{name}", "```", ""]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines), encoding="utf-8")
