"""Import the simulator for the commands that need it, or say in one line how to install it."""

from __future__ import annotations

from types import ModuleType

from scalar.errors import Fault, InvalidInput

_ENGINE = "pybullet"


def simulator(command: str, instead: str = "") -> ModuleType:
    """Return the package ``scalar.simulation``.

    Args:
        command: Name of the command that needs it, for the message.
        instead: What to do without it, for the end of the message.

    Raises:
        InvalidInput: The physics engine is not installed.
    """
    try:
        import scalar.simulation as simulation
    except ImportError as error:
        if not any(getattr(e, "name", None) == _ENGINE for e in (error, error.__cause__, error.__context__)):
            raise
        message = f"needs the simulator's {_ENGINE}, which is not installed; pip install 'scalar-calibration[simulation]'{instead}"
        raise InvalidInput(Fault(f"scalar {command}", message)) from None
    return simulation
