"""The base class of errors within a scanner's profiles without a name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.picture import Map, Profile, View
from scalar.effects.range_error import ScannerError


class UnattributedProfileError(Unattributed, ScannerError):
    """An error of the points of a scanner's profiles, of which there is one kind at each ``place``; by default it has no settings."""

    @property
    def key(self) -> str:
        """Name and place."""
        return f"{NAME}_{self.place}"

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return none: the text states the size."""
        return []

    def to_mapping(self) -> dict[str, Any]:
        """Return the place."""
        return {"place": self.place}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term."""
        return cls()
