"""The noise within scans, from each scan's residual about its own line or parabola, which errors of the arm do not affect.

An error of the arm moves a scan as a whole: it shifts and rotates the line, and bends it by less than can be measured. The residual about
the scan's own line therefore comes from the scanner and the surface alone. It shows whether the errors of points are independent (``whiteness``),
how they grow with range and incidence (``level``), and how far along the scan they are correlated (``correlation``), by restricted likelihood
(``restricted_likelihood``). From that follows the covariance of the three rows to which a scan is compressed (``row_covariance``).
If the noise proves white and of one size, nothing is changed.
"""

from scalar.sensors.within_scan_noise.estimate import noise_within_scans
from scalar.sensors.within_scan_noise.profiles import Profiles
from scalar.sensors.within_scan_noise.row_covariance import long_waves

__all__ = ["Profiles", "long_waves", "noise_within_scans"]
