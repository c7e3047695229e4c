"""Effects as a command line names them: ``NAME[:TARGET[:...]]``, separated by commas."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import TYPE_CHECKING

from scalar.effects import registry
from scalar.effects.effect import Effect
from scalar.effects.title_reader import with_names
from scalar.errors import Fault, InvalidInput

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

OPTION = "--effects"


def parse_effects(text: str, dataset: Dataset) -> tuple[Effect, ...]:
    """Return the effects that a command line names.

    Joints, orders, planes and moments follow the name, as each effect says: ``joint_harmonic:4:2``, ``joint_coupling:6:5``,
    ``plane_bow:floor``, ``sensor_slip:120``. Without a target an effect is freed wherever it can act. Titles as report and terminal write them,
    such as ``joint 3: tilted axis``, mean the same.

    Raises:
        InvalidInput: An unknown name, or a target that this dataset lacks.
    """
    kinds = {name: kind for name, kind in registry.known().items() if not kind.flexible}
    effects: list[Effect] = []
    faults = []
    for word in (part.strip() for part in with_names(text, kinds).split(",")):
        if not word:
            continue
        name, *target = word.split(":")
        if name not in kinds:
            close = difflib.get_close_matches(name, kinds, n=1)
            hint = (
                f"; did you mean {close[0]}?"
                if close
                else f"; there are {', '.join(kinds)}; one of your own needs --effects-module FILE.py"
            )
            faults.append(Fault(OPTION, f"no effect '{name}' that can be freed{hint}"))
            continue
        try:
            if len(target) > kinds[name].most_words:
                raise ValueError(f"too many words after '{name}'")
            effects += kinds[name].parsed(dataset, target)
        except ValueError as error:
            faults.append(Fault(OPTION, f"{word}: {error}"))
    keys = [effect.key for effect in effects]
    faults += [
        Fault(OPTION, f"'{key}' is named twice") for key in sorted({k for k in keys if keys.count(k) > 1})
    ]
    if faults:
        raise InvalidInput(faults)
    return tuple(effects)


def named_effects(effects: Iterable[Effect]) -> str:
    """Return what a command line says to free all these effects, each once: the argument that ``parse_effects`` reads.

    Several joints of one effect (a compliance) are named together, and so are orders of one joint. Flexible effects have no name on the command
    line and are left out.
    """
    joints: dict[str, set[int]] = {}
    places: dict[tuple[str, ...], set[int]] = {}
    for effect in effects:
        if effect.flexible:
            continue
        target = dict(effect.target)
        if not target and hasattr(effect, "by"):  # a drift acts at no place; it grows along a column
            target["by"] = vars(effect)["by"]
        orders = {*target.pop("orders", ()), *([target.pop("order")] if "order" in target else [])}
        joints.setdefault(effect.name, set()).update(target.pop("joints", ()))
        words = (
            f"{value['order']:g}" if isinstance(value, dict) else f"{value}" for value in target.values()
        )
        places.setdefault((effect.name, *words, *effect.command_words), set()).update(orders)
    named: list[str] = []
    for (name, *words), orders in places.items():
        words = words or [f"{joint}" for joint in sorted(joints[name])]
        named.append(":".join([name, *words, *(f"{order}" for order in sorted(orders))]))
    return ",".join(named)
