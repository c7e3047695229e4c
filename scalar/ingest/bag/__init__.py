"""Recorded ROS bags as datasets: read messages, find the moments at which the arm stands still, and cut scans to the target planes."""

STILL = 5e-4
"""Default of the most by which a joint that stands still may move [rad, m]: encoders dither, and brakes yield a little."""
SETTLED = 0.2
"""Default of the time from the last motion until the arm counts as settled [s]. Chosen."""
LEAST_TIME = 0.3
"""Default of the least time for which it then stands still [s]. Chosen."""
