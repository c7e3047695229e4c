"""Recorded ROS bags as datasets: messages, moments at which the arm stands still, scans cut to the target planes."""

STILL = 5e-4
"""Positions that stay within this [rad, m] do not move; encoders and brakes give a little."""
SETTLED = 0.2
"""Time after the last motion [s] from which on the arm is taken to have settled (chosen)."""
LEAST = 0.3
"""Time [s] that it then stands still at least."""
