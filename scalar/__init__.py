"""Calibrate a serial robot and the sensor on its flange, together, from scans of three rough planes.

The method is that of Lembono, Suárez-Ruiz and Pham (IROS 2018): every laser point has to lie on a plane whose
place is itself unknown. That constraint alone determines the kinematic parameters of the arm and the pose of
the scanner, up to a gauge that is derived and reported, not assumed. Data flows one way: dataset ->
residuals -> calibration -> evaluation or diagnosis -> report.

Lengths are metres, angles radians, arrays float64. Importing this package imports nothing else, so that
`scalar --help` and every small workflow job start quickly; `scalar.simulation` alone needs pybullet.
"""

__version__ = "0.1.0"
