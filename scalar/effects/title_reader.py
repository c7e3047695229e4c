"""Effects by their titles, as report and terminal name them: "joint 4: harmonic error, order 2" is joint_harmonic:4:2."""

from __future__ import annotations

import re
from collections.abc import Mapping

from scalar.effects.effect import Effect

_NUMBERS = r"\d+(?:(?:, and |, | and )\d+)*"


def with_names(text: str, kinds: Mapping[str, type[Effect]]) -> str:
    """Return what a command line says of effects with each title replaced by the name and the target that it means.

    Args:
        text: Titles and names, separated by commas; quotes around titles and capitals do not matter.
        kinds: The kinds of effects by their names.
    """
    names = {kind.kind.lower(): name for name, kind in kinds.items() if kind.kind}
    titles = "|".join(re.escape(kind) for kind in sorted(names, key=len, reverse=True))
    if not titles:
        return text
    of_joint = (
        rf"joints? (?P<joints>{_NUMBERS}): (?P<of_joint>{titles})(?: from joint (?P<source>\d+))?"
        rf"(?:, orders? (?P<orders>{_NUMBERS}))?"
    )
    of_plane = rf"target plane (?P<plane>[^,:]+): (?P<of_plane>{titles})"
    warm_up = r"(?P<warm_up>warm-up) \(constant [^)]*\)"
    anywhere = rf"(?P<anywhere>{titles})(?: \(constant [^)]*\))?"
    since = r"(?:, from (?:pose -?\d+ \()?order (?P<start>\d+)\)?(?: \(pose -?\d+\))? on)?(?: in the course of acquisition| with (?P<by>[a-z]+))?"
    pattern = (
        rf"(?<![^\s,\"'“])[\"'“]?(?:{of_joint}|{of_plane}|{warm_up}|{anywhere}){since}[\"'”]?(?![^\s,:])"
    )

    def named(found: re.Match[str]) -> str:
        """Return the words of ``--effects`` for a title that was found."""
        kind = found["of_joint"] or found["of_plane"] or found["anywhere"] or "thermal drift"
        numbers = [
            *re.findall(r"\d+", found["joints"] or ""),
            found["source"],
            *re.findall(r"\d+", found["orders"] or ""),
        ]
        by = found["by"] or ("order" if "course of acquisition" in found[0] else None)
        words = [names[kind.lower()], *numbers, found["plane"], found["start"], by]
        return ":".join(word for word in words if word)

    return re.sub(pattern, named, text, flags=re.IGNORECASE)
