"""Why stops of a recording became no poses: how many for each reason, and what to try."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.ingest.bag.labels import FARTHEST

LEAST_KEPT = 0.5
"""Least share of the stops that have to become poses. Chosen: stops between poses are few, and with a wrong order of joints hardly any scan is on a
plane."""
_REMEDIES = {
    "without a scan": "record the scanner all the time, stop longer than a scan takes, and check that the stamps of both topics are of one clock",
    "without a straight piece in the scan": (
        "check that the scanner sees 2 cm or more of a target plane there, that its topic is in metres, and that sensor.noise is not too small"
    ),
    "on no plane, or near two": (
        "check the order of the joints (--joint-names), whether each counts in the direction and from the zero that robot.joints states, "
        f"sensor.nominal_pose with the direction of its axes, and the guesses of the planes, which may be off by {FARTHEST:g} m"
    ),
}


@dataclass(frozen=True)
class StopCounts:
    """How many stops of a recording became poses, and why the others did not.

    Attributes:
        still: Number of moments at which the arm stood still.
        without_scan: Of these, moments without a scan.
        without_piece: Scans without a straight piece.
        without_plane: Pieces near no plane, or near two.
        joint_names: Names of the recorded joints in the order in which they became q1..qn.
    """

    still: int
    without_scan: int
    without_piece: int
    without_plane: int
    joint_names: tuple[str, ...]

    @property
    def kept(self) -> int:
        """Return the number of stops that became poses."""
        return self.still - self.without_scan - self.without_piece - self.without_plane

    @property
    def reasons(self) -> dict[str, int]:
        """Return the number of stops that were left out for each reason, the most frequent first."""
        counts = (self.without_scan, self.without_piece, self.without_plane)
        found = zip(_REMEDIES, counts, strict=True)
        return dict(sorted(((why, n) for why, n in found if n), key=lambda entry: -entry[1]))

    def sentence(self, more: str = "") -> str:
        """Return a message: how many stops became poses, the text `more`, why the others did not, and what to try."""
        reasons = self.reasons
        listed = ", ".join(f"{n} {why}" for why, n in reasons.items())
        left = f" (left out: {listed})" if reasons else ""
        first = next(iter(reasons), "on no plane, or near two")
        return f"{self.kept} of {self.still} stops became poses{left}{more}: {_REMEDIES[first]}"
