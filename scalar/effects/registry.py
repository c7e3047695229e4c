"""The one list of effects: those of this package, of installed packages, and of files that a user names.

An installed package offers effects by the entry point group ``scalar.effects``, each entry being a class or a module that defines some. A file
is loaded by ``load_file``, as the option ``--effects-module`` does. A saved effect keeps the name of the module that it came from. When it is read,
that name is only looked up in this list: a module is never imported because a saved file names it.
"""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.effect import Effect
from scalar.effects.flexible.unattributed import Unattributed
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_coupling import JointCoupling
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_hysteresis import JointHysteresis
from scalar.effects.joint_ripple import JointRipple
from scalar.effects.joint_scale import JointScale
from scalar.effects.payload_deflection import PayloadDeflection
from scalar.effects.places import OneJoint
from scalar.effects.plane_bow import PlaneBow
from scalar.effects.plane_moved import PlaneMoved
from scalar.effects.pose_lag import PoseLag
from scalar.effects.range_distortion import RangeDistortion
from scalar.effects.range_offset import RangeOffset
from scalar.effects.range_scale import RangeScale
from scalar.effects.restarted_warm_up import RestartedWarmUp
from scalar.effects.sensor_map import SensorMap
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.target_drift import TargetDrift
from scalar.effects.thermal_drift import ThermalDrift
from scalar.effects.torque_compliance import TorqueCompliance
from scalar.errors import Fault, InvalidInput

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

GROUP = "scalar.effects"
OPTION = "--effects-module"

BUILT_IN: tuple[type[Effect], ...] = (
    JointCompliance,
    TorqueCompliance,
    PayloadDeflection,
    BaseCompliance,
    JointHarmonic,
    JointRipple,
    JointScale,
    JointCoupling,
    JointBacklash,
    JointHysteresis,
    PoseLag,
    AxisNonparallel,
    ThermalDrift,
    RestartedWarmUp,
    TargetDrift,
    SensorSlip,
    RangeScale,
    RangeOffset,
    RangeDistortion,
    SensorMap,
    PlaneBow,
    PlaneMoved,
    Unattributed,
)

_OF_USERS: dict[str, tuple[type[Effect], str]] = {}  # by name: the class and the module that it came from
_asked = False  # whether the entry points of installed packages have been loaded


def known() -> dict[str, type[Effect]]:
    """Return every kind of effect by its name, the package's own first."""
    return {kind.name: kind for kind in BUILT_IN} | {name: kind for name, (kind, _) in _of_users().items()}


def missing_nuisances(dataset: Dataset, effects: Sequence[Effect]) -> list[Effect]:
    """Return the nuisances (``Effect.in_every_setup``) at places at which none of some effects acts."""
    kinds = [kind for kind in known().values() if kind.in_every_setup]
    possible = [nuisance for kind in kinds for nuisance in kind.candidates(dataset)]
    return [e for e in possible if not any(e.same_place(other) for other in effects)]


def module_of(effect: Effect) -> str | None:
    """Return the module that an effect came from; None for the package's own."""
    entry = _of_users().get(effect.name)
    return entry[1] if entry is not None and isinstance(effect, entry[0]) else None


def kind_named(name: str, module: str | None = None) -> type[Effect]:
    """Return the kind of effect with a name.

    Args:
        name: Name of the effect.
        module: The module that it came from, as saved; None for an effect of this package.

    Raises:
        InvalidInput: The module is absent, or the name is unknown.
    """
    if module is not None:
        entry = _of_users().get(name)
        if entry is None or entry[1] != module:
            message = f"the effect '{name}' comes from the module '{module}', which is absent"
            raise InvalidInput(
                Fault(name, f"{message}: install it, or name its file with {OPTION} {module}.py")
            )
        return entry[0]
    if name not in known():
        raise InvalidInput(Fault(name, f"no effect '{name}'; there are {', '.join(known())}"))
    return known()[name]


def freed_by(parameter: str) -> str | None:
    """Return the name of the effect that frees a kind of geometric parameter (``beta``), or None."""
    return next((name for name, kind in known().items() if kind.frees == parameter), None)


def load_file(path: str | Path) -> list[type[Effect]]:
    """Return the effects that a Python file defines, known from now on by the name of the file as their module.

    Raises:
        InvalidInput: The file cannot be read, does not run, defines no effect, or one whose name is taken.
    """
    path = Path(path)
    if not path.is_file():
        raise InvalidInput(
            Fault(str(path), f"no such file; {OPTION} takes a Python file that defines effects")
        )
    spec = importlib.util.spec_from_file_location(f"_scalar_effects_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InvalidInput(Fault(str(path), f"no Python file; {OPTION} takes one that defines effects"))
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever a user's file does wrong is a fault of that file
        raise InvalidInput(Fault(str(path), f"does not run: {type(error).__name__}: {error}")) from error
    kinds = list(_defined_in(module))
    if not kinds:
        _refuse_incomplete(module, str(path))
    return _registered(kinds, path.stem, str(path))


def _of_users() -> dict[str, tuple[type[Effect], str]]:
    """Return the effects from outside, those of installed packages included."""
    global _asked
    if not _asked:
        _asked = True
        for entry in entry_points(group=GROUP):
            try:
                loaded = entry.load()
            except Exception as error:
                message = f"the entry point '{entry.name}' does not load: {type(error).__name__}: {error}"
                raise InvalidInput(Fault(GROUP, message)) from error
            kinds = _defined_in(loaded) if isinstance(loaded, ModuleType) else [loaded]
            _registered(kinds, entry.module, f"entry point '{entry.name}'")
    return _OF_USERS


def _defined_in(module: ModuleType) -> Iterator[type[Effect]]:
    """Return the effects that a module itself defines, in their order."""
    for value in vars(module).values():
        own = isinstance(value, type) and value.__module__ == module.__name__
        if own and issubclass(value, Effect) and not inspect.isabstract(value) and "name" in vars(value):
            yield value


def _refuse_incomplete(module: ModuleType, where: str) -> None:
    """Refuse a file in which a class has the name of an effect and lacks methods that every effect of its place has."""
    faults = []
    for value in vars(module).values():
        own = isinstance(value, type) and value.__module__ == module.__name__ and issubclass(value, Effect)
        if own and inspect.isabstract(value) and "name" in vars(value):
            lacking = sorted(value.__abstractmethods__)
            also = ", or subclass OneJoint too" if set(lacking) <= OneJoint.__dict__.keys() else ""
            faults.append(
                Fault(where, f"the effect {value.__name__} lacks {', '.join(lacking)}: define this{also}")
            )
    if faults:
        raise InvalidInput(faults)


def _registered(kinds: Iterable[type[Effect]], module: str, where: str) -> list[type[Effect]]:
    """Return effects from outside, entered by their names.

    Raises:
        InvalidInput: There are none, or another effect has the name.
    """
    kinds = list(kinds)
    if not kinds:
        raise InvalidInput(
            Fault(where, "defines no effect: subclass a place of scalar.effects and give it a name")
        )
    for kind in kinds:
        other = _OF_USERS.get(kind.name)
        if kind.name in {own.name for own in BUILT_IN} or (other is not None and other[1] != module):
            raise InvalidInput(
                Fault(where, f"another effect is called '{kind.name}'; give this one a name of its own")
            )
        _OF_USERS[kind.name] = kind, module
    return kinds
