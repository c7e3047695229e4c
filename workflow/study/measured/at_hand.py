"""Which measured sets can be studied: those whose original files lie in a folder, were fetched before, or can be fetched.

A warning names the missing files and says what to do; the other sets are studied all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from study.measured.originals import Original, answers


@dataclass(frozen=True)
class SetsAtHand:
    """The measured sets at hand. They are looked for once, when they are first asked for, since the search may use the network.

    Attributes:
        originals: ``{set: its original files}``.
        folder: Local folder with original files; empty if there is none.
        addresses: Templates of addresses in the network, as ``Original.addresses`` takes them.
        kept: Folder in which each set that was fetched before has a folder with the set's name.
        transfers: ``{set: the set whose effects are applied to it}``.
        warn: Function that is called with a sentence about the missing files, if any are missing.
    """

    originals: Mapping[str, Sequence[Original]]
    folder: str
    addresses: Sequence[str]
    kept: Path
    transfers: Mapping[str, str]
    warn: Callable[[str], None]

    @cached_property
    def names(self) -> list[str]:
        """The sets at hand, in the order of the originals; all of them if a missing file can be downloaded."""
        missing = self._missing()
        if missing and any(map(answers, next(iter(missing.values()))[0].addresses(self.addresses))):
            return list(self.originals)
        if missing:
            self.warn(self._what_to_do(missing))
        return [name for name in self.originals if name not in missing]

    @property
    def transferred(self) -> dict[str, str]:
        """The transfers of which both sets are at hand."""
        return {name: other for name, other in self.transfers.items() if {name, other} <= set(self.names)}

    def _missing(self) -> dict[str, list[Original]]:
        """Return ``{set: files that are not here}``, without the network."""
        folder = Path(self.folder) if self.folder else None
        absent = {
            name: [file for file in files if folder is None or file.find(folder) is None]
            for name, files in self.originals.items()
        }
        return {name: files for name, files in absent.items() if files and not (self.kept / name).is_dir()}

    def _what_to_do(self, missing: Mapping[str, Sequence[Original]]) -> str:
        """Return the warning that names the missing files, and says what to do."""
        where = f"in measured.folder ({self.folder})" if self.folder else "here (measured.folder is not set)"
        files = "; ".join(
            f"{name}: {', '.join(file.file for file in absent)}" for name, absent in missing.items()
        )
        return (
            f"measured: these original files are neither {where} nor to be had from the network now: {files}. "
            "To have them, say --config 'measured={folder: PATH}' with a folder that holds them "
            "(workflow/resources/measured.csv lists repositories and checksums), or try again with a network. "
            f"Left out until then: {', '.join(missing)}."
        )
