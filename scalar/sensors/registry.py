"""The known kinds of sensor: the package's own, those of installed packages, and those that a program registers."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, TypeVar

from scalar.data.sensor_formats import add_format, remove_format
from scalar.errors import Fault, InvalidInput
from scalar.sensors.line_laser import LineLaser
from scalar.sensors.probe import Probe
from scalar.sensors.protocol import Measurement
from scalar.sensors.tracker import Tracker

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

GROUP = "scalar.sensors"  # of entry points: each names a class with the protocol of ``Measurement``

_K = TypeVar("_K", bound=Measurement)

_kinds: dict[str, type[Measurement]] = {}


def register(kind: type[_K]) -> type[_K]:
    """Register a kind of sensor and its dataset format, and return it; can be used as a decorator of its class.

    Raises:
        ValueError: Another class is registered under the same name of a kind.
    """
    name = kind.format.kind
    if _kinds.get(name, kind) is not kind:
        raise ValueError(f"a kind of sensor '{name}' is registered already: {_kinds[name].__qualname__}")
    _kinds[name] = kind
    add_format(kind.format)
    return kind


def unregister(kind: type[Measurement]) -> None:
    """Remove a kind of sensor that was registered.

    Raises:
        KeyError: It is not registered.
    """
    del _kinds[kind.format.kind]
    remove_format(kind.format.kind)


def kind_named(name: str) -> type[Measurement]:
    """Return the class of a kind of sensor by its name.

    Raises:
        InvalidInput: No such kind is registered; the package that defines it is perhaps not installed.
    """
    if name not in _kinds:
        message = f"unknown kind of sensor '{name}'; this installation has {', '.join(_kinds)}; for another, install the package that defines it"
        raise InvalidInput(Fault("sensor", message, None, "kind"))
    return _kinds[name]


def kind_of(dataset: Dataset) -> type[Measurement]:
    """Return the kind of a dataset's sensor."""
    return kind_named(dataset.sensor.kind)


def measure(dataset: Dataset, extra_basis: Sequence[str] = ()) -> Measurement:
    """Return the measurement of a dataset, an object of the class of its kind of sensor.

    Args:
        dataset: What was measured.
        extra_basis: Names of functions of a point that compression has to keep for effects on points (``scalar.sensors.profile.point_basis``).
    """
    return kind_of(dataset).of(dataset, extra_basis)


def _register_installed() -> None:
    """Register the kinds that installed packages name as entry points.

    Raises:
        InvalidInput: One of them cannot be imported.
    """
    for entry in entry_points(group=GROUP):
        try:
            register(entry.load())
        except (ImportError, AttributeError) as error:
            raise InvalidInput(
                Fault(
                    f"entry point {GROUP}",
                    f"'{entry.value}' cannot be loaded ({error}); repair or uninstall it",
                )
            ) from error


for _kind in (LineLaser, Probe, Tracker):
    register(_kind)
_register_installed()
