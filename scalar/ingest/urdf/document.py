"""Read the XML of a robot description without opening anything that it refers to.

URDF needs no document type, so a file that declares one is refused: with entities, a small file can fill the memory or
read other files. The whole XML is kept, with comments and elements that this package does not use, so that an export changes
only the geometry.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scalar.data.io.regular_file import read_regular_file
from scalar.data.located_table import shorten
from scalar.errors import Fault, InvalidInput

MAX_URDF_BYTES = 4_000_000
"""Largest size of a robot description [bytes]; those of humanoids have less than 1 MB, since meshes are files of their own."""
_DECLARATION = re.compile(rb"<!\s*(DOCTYPE|ENTITY)", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class UrdfDocument:
    """A parsed robot description.

    Attributes:
        file: Name of the file in messages.
        root: The element ``<robot>`` (of lxml).
    """

    file: str
    root: Any

    @property
    def name(self) -> str:
        """Return the name of the robot."""
        return str(self.root.get("name") or Path(self.file).stem)

    def refusal(self, element: Any, message: str) -> InvalidInput:
        """Return an error with this message that names the line of an element."""
        return InvalidInput(Fault(self.file, message, element.sourceline))

    def named(self, tag: str) -> dict[str, Any]:
        """Return the elements ``<link>`` or ``<joint>`` of the robot by name.

        Raises:
            InvalidInput: One has no name, or two have the same.
        """
        found: dict[str, Any] = {}
        for element in self.root.iterchildren(tag):
            name = element.get("name")
            if not name:
                raise self.refusal(element, f"a {tag} without a name; name it")
            if name in found:
                row = found[name].sourceline
                raise self.refusal(
                    element, f"the {tag} {shorten(name)} is already defined in line {row}; rename one"
                )
            found[name] = element
        return found


def read_urdf(path: str | Path) -> UrdfDocument:
    """Return the robot description in a file.

    Raises:
        InvalidInput: The file cannot be read, is longer than 4 MB, is no XML, declares a document type, or is no URDF.
    """
    import lxml.etree as etree

    file = str(path)
    raw = read_regular_file(Path(path), MAX_URDF_BYTES, file)
    declaration = _DECLARATION.search(raw)
    if declaration:
        raise InvalidInput(_declared(file, raw.count(b"\n", 0, declaration.start()) + 1))
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    try:
        root = etree.fromstring(raw, parser)
    except etree.XMLSyntaxError as error:
        words = " ".join((error.msg or "a syntax error").split())
        raise InvalidInput(Fault(file, f"not XML ({words}); give a URDF file", error.lineno)) from None
    except (ValueError, LookupError) as error:
        raise InvalidInput(Fault(file, f"not XML ({error}); give a URDF file")) from None
    # In another encoding, such as UTF-16, the search above does not find a declaration.
    if root.getroottree().docinfo.internalDTD is not None:
        raise InvalidInput(_declared(file, None))
    if any(isinstance(e.tag, str) and e.tag.startswith("{") and "xacro" in e.tag for e in root.iter()):
        message = "a xacro file, not a URDF; expand it first, as in: xacro robot.urdf.xacro > robot.urdf"
        raise InvalidInput(Fault(file, message))
    if root.tag != "robot":
        message = f"not a URDF: its root is {shorten(str(root.tag))} and not 'robot'; give a URDF file"
        raise InvalidInput(Fault(file, message, root.sourceline))
    return UrdfDocument(file, root)


def _declared(file: str, row: int | None) -> Fault:
    return Fault(
        file, "declares a document type or an entity, which a URDF does not need; remove the declaration", row
    )
