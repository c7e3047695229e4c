"""The base class of flexible terms, which correct structure that no named effect explains, without naming its cause.

Most are smooth in one or two variables: an error of one joint's angle, of one link's geometry, or of the sensor's pose. Outside the range of the data
to which they were fitted, functions of a variable keep the value at the nearer end, so that they do not grow there. Others have the form of a
cause that is no effect of the catalogue, and are rivals of effects that look alike: a scanner that errs with the incidence, for example.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Self

from scalar.effects.effect import Effect, Table
from scalar.effects.flexible.first_steps import first_steps
from scalar.effects.wording import columns_in_words

NAME = "unattributed"


class Unattributed(Effect):
    """A flexible term, named ``unattributed``. Subclasses state their ``place``, by which a file says which of them it holds."""

    name: ClassVar[str] = NAME
    kind: ClassVar[str] = "unmodelled structure"
    sentence: ClassVar[str] = "the residual has structure that no known effect explains"
    flexible: ClassVar[bool] = True
    place: ClassVar[str] = ""

    @property
    def target(self) -> dict[str, Any]:
        """Return nothing, because it is not known what the structure acts on."""
        return {}

    @property
    def erring_joint(self) -> int | None:
        """Return None, because a flexible term is not one of a joint's named errors."""
        return None

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Any:
        """Return the term of ``to_mapping``, of the place that it names."""
        return _of_place(mapping["place"]).from_settings(mapping)

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of this class that ``to_mapping`` wrote."""
        raise NotImplementedError

    @property
    def clause(self) -> str:
        """Return that there is structure, and what it depends on."""
        return self.clause_of([self])

    @classmethod
    def clause_of(cls, effects: Sequence[Effect]) -> str:
        """Return that there is structure, and what it depends on."""
        names = list(dict.fromkeys(name for effect in effects for name in effect.depends_on))
        return (
            f"there is structure that no known effect explains, which varies with {columns_in_words(names)}"
        )

    @property
    def advice(self) -> list[str]:
        """Return how to look for its cause."""
        return first_steps(self.depends_on)

    def table(self, std: Sequence[float | None]) -> Table | None:
        """Return None, because the coefficients of a flexible term mean nothing to a reader."""
        return None


def _of_place(place: str) -> type[Unattributed]:
    """Return the class of flexible terms that act at a place, as ``to_mapping`` names it."""

    def below(cls: type[Unattributed]) -> list[type[Unattributed]]:
        return [found for sub in cls.__subclasses__() for found in (sub, *below(sub))]

    return next(cls for cls in below(Unattributed) if cls.place == place)
