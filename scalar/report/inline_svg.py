"""Turn an SVG file of Matplotlib into an element of the page.

Text stays text, in the fonts of the page. Colours become variables of the page's style sheet, which has other values for
dark screens. Coordinates are rounded to a tenth of a point. Identifiers are unique in the
page. Every dot gets a ``<title>``, which browsers show when the dot is pointed at: no script is needed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from xml.etree import ElementTree

COLOURS = {
    "ink": ("#1b1f24", "#e6e9ec"),
    "soft": ("#57606a", "#a3adb8"),
    "rule": ("#d8dde3", "#3a424b"),
    "grid": ("#e7eaee", "#2b323a"),
    "zero": ("#8b949e", "#6d7681"),
    "blue": ("#0b5a94", "#6db3e8"),
    "orange": ("#c25100", "#f2994a"),
    "green": ("#1a7f5a", "#5cc49a"),
    "purple": ("#6a3d9a", "#b594e0"),
    "dot": ("#2f77ad", "#5fa5d8"),
    "fill": ("#a9c4da", "#3f6583"),
    "heat0": ("#fdf3e3", "#2b241d"),
    "heat1": ("#fde4c2", "#413222"),
    "heat2": ("#fdcf9a", "#5c4226"),
    "heat3": ("#fcb377", "#7c5228"),
    "heat4": ("#f58f57", "#a16229"),
    "heat5": ("#e3683c", "#c8742c"),
    "heat6": ("#c33f24", "#e79143"),
    "heat7": ("#962013", "#f6b56f"),
    "heat8": ("#64100c", "#ffdcae"),
}
"""The colours of charts and page by name: on a light screen and paper, and on a dark screen."""

_SVG, _HREF = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}href"
_NUMBER = re.compile(r"-?\d+\.\d+")
_REFERENCE = re.compile(r"url\(#([^)]+)\)")
_NAMES = {light: f"var(--{name})" for name, (light, _) in COLOURS.items()}
_FAMILY = re.compile(r"font-family: [^;]*;? ?")
_COORDINATES = ("d", "x", "y", "width", "height")
_HEX = re.compile("|".join(_NAMES))


def plain_text(text: str) -> str:
    """Return a text without the characters that XML does not allow."""
    return "".join(c if c.isprintable() else " " for c in text)


def inlined(svg: str, alt: str, titles: Mapping[str, Sequence[str]]) -> str:
    """Return an SVG file of Matplotlib as an element of an HTML page.

    Args:
        svg: Content of the file.
        alt: What the picture shows, in words.
        titles: For each group of marks, by its identifier, the texts that its marks show when they are pointed at; empty
            if they show none.
    """
    root = ElementTree.fromstring(svg)
    for parent in list(root.iter()):
        for child in list(parent):
            empty = child.tag == f"{_SVG}g" and not len(child)
            if empty or child.tag in (f"{_SVG}metadata", f"{_SVG}style"):
                parent.remove(child)
    for group in root.iter(f"{_SVG}g"):
        if group.get("id") in titles:
            _share_style(group, titles[group.attrib["id"]])
    # Each picture in the page has its own identifiers, and the same ones each time.
    prefix = "p" + sha256((alt + svg).encode()).hexdigest()[:6]
    used = {e.attrib[_HREF].removeprefix("#") for e in root.iter() if _HREF in e.attrib}
    used |= {name for e in root.iter() for name in _REFERENCE.findall(e.get("clip-path", ""))}
    short = {name: f"{prefix}-{i}" for i, name in enumerate(sorted(used))}
    box = root.attrib["viewBox"]
    for element in root.iter():
        element.tag = element.tag.removeprefix(_SVG)
        element.attrib = dict(_attributes(element.attrib, short))
        if not (element.text or "").strip():
            element.text = None
        element.tail = None
    root.attrib = {"viewBox": box, "class": "chart", "role": "img", "aria-label": alt}
    return ElementTree.tostring(root, encoding="unicode")


def _share_style(group: ElementTree.Element, titles: Sequence[str]) -> None:
    """Move the style that all marks of a group share to the group, and give each mark its title."""
    marks = list(group.iter(f"{_SVG}use"))
    for mark in marks:
        group.set("style", mark.attrib.pop("style", ""))
    if titles:
        group.set("class", "dots")
        for mark, title in zip(marks, titles, strict=True):
            ElementTree.SubElement(mark, f"{_SVG}title").text = title


def _attributes(attributes: Mapping[str, str], short: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield attributes with rounded coordinates, short identifiers and colours by name."""
    for name, value in attributes.items():
        if name == "id":
            if value in short:
                yield name, short[value]
        elif name == _HREF:
            yield "href", f"#{short[value.removeprefix('#')]}"
        elif name == "clip-path":
            yield name, _REFERENCE.sub(lambda m: f"url(#{short[m.group(1)]})", value)
        elif name == "style":
            yield name, _HEX.sub(lambda m: _NAMES[m.group()], _FAMILY.sub("", value))
        elif name in _COORDINATES:
            yield (
                name,
                _NUMBER.sub(lambda m: f"{float(m.group()):.1f}".removesuffix(".0"), " ".join(value.split())),
            )
        elif not value.startswith("rotate(-0 "):
            yield name, value
