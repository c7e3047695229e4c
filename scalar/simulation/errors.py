"""The simulator's own error: the config is well formed, but the workcell that it describes cannot be simulated."""

from scalar.errors import ScalarError


class SimulationError(ScalarError):
    """The workcell cannot be simulated as configured: the message says what failed and what to change."""

    exit_status = 2
