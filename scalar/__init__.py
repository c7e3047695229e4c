"""Calibrate a serial robot and the sensor on its flange, together, and find what the rigid model lacks.

The method is that of Lembono, Suárez-Ruiz and Pham (IROS 2018): every laser point has to lie on a plane whose
place is itself unknown. That constraint alone determines the kinematic parameters of the arm and the pose of
the scanner, up to a gauge that is derived and reported, not assumed. Data flows one way: dataset ->
residuals -> calibration -> evaluation or diagnosis -> report.

Lengths are metres, angles radians, arrays float64. A name of this package is imported when it is first used, so
that `import scalar` costs next to nothing; `__init__.pyi` says where each name stands. `scalar.simulation` alone
needs pybullet.
"""

import lazy_loader

from scalar.data.sensor_formats import supply_from

__version__ = "0.2.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def _kinds_of_sensor() -> None:
    import scalar.sensors  # noqa: F401 - registers the kinds, with the format that each has in a dataset folder


supply_from(_kinds_of_sensor)
