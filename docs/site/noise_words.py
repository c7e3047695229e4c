"""What the pages of the two random errors say: their model, their cause, how sure the name is, and what to do."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.diagnosis.naming.most_confidence import NOT_SURE
from scalar.report.noise_card import COMPARE_WITH_DATA_SHEET, REPEAT_POSES, SEVERAL_SCANS, SURE, WAIT


@dataclass(frozen=True)
class NoiseWords:
    """A random error as its page describes it.

    Attributes:
        sentence: What it is; stands in the table of effects as well.
        model: Which rows it changes, and how it is found.
        cause: Where it comes from in real workcells.
        how_sure: What limits the confidence in its name.
        advice: What to do about it, the first step first.
        in_picture: What the left-hand picture shows of it.
    """

    sentence: str
    model: str
    cause: str
    how_sure: str
    advice: tuple[str, ...]
    in_picture: str


_COMMON_RULE = (
    "It is reported only if the residuals show no significant autocorrelation, and if it explains their scatter better than the sensor's own noise "
    "does (a noise that is larger than stated, or an error that extends over a whole scan)."
)

NOISE_WORDS = {
    "pose_jitter": NoiseWords(
        sentence="Each pose repeats only to a spread in the joints. This is a random error and is reported as a standard deviation [rad].",
        model=(
            "At each pose, the angle of every revolute joint has an error of its own, with zero mean and the same variance $v$ [rad²]. It adds "
            "$v\\, D_i D_i^\\mathsf{T}$ to the covariance of the rows of pose $i$, where $D_i$ has their derivatives by the joint angles "
            "([the mathematics](../../mathematics.md)). $v$ is found by restricted likelihood. If the order of the poses is known, a part may lie "
            "along the last move (`along_last_move_rad`)."
        ),
        cause=(
            "Friction and play that leave the joint elsewhere at each visit, brakes that close unevenly, or a measurement that is taken, or joint "
            "angles that are logged, before the arm stands still. Data sheets state it as the repeatability (ISO 9283); a standard deviation below "
            "0.00002 rad (0.0011°) is no finding, because any arm has one of that size."
        ),
        how_sure=(
            f"{_COMMON_RULE} Its confidence is at most {NOT_SURE:g} unless the arm came back to some of the poses and erred otherwise there: "
            "over poses that all differ, the pull of a hose or a loose mount scatters as a jitter does. Without such returns it keeps its name only "
            "if neighbouring poses show that most of the scatter does not vary smoothly with the joint angles, which takes some hundred poses or "
            "more, and if no unmodelled structure was found as well; else it is reported as unmodelled structure that resembles a jitter. "
            "A random error at one place, such as one joint or the mount, that explains the scatter clearly better is reported in its stead as "
            "unmodelled structure."
        ),
        advice=(
            f"If its confidence is below {SURE:g}: {REPEAT_POSES[:1].lower()}{REPEAT_POSES[1:]}",
            f"If the error lies mostly along the last move: {WAIT[:1].lower()}{WAIT[1:]}",
            f"Otherwise: {COMPARE_WITH_DATA_SHEET[:1].lower()}{COMPARE_WITH_DATA_SHEET[1:]}",
        ),
        in_picture="The scatter grows to the right: an error of an angle moves the scanner farther, the longer its lever.",
    ),
    "scan_bias": NoiseWords(
        sentence="Each scan has an error of its own, common to its points. It is reported as a standard deviation [m].",
        model=(
            "All points of scan $i$ err by the same draw, with zero mean and variance $v$ [m²]. It adds $v\\, D_i D_i^\\mathsf{T}$ to the "
            "covariance of the rows of the scan, where $D_i$ has their derivatives by an error common to its points. It shifts the scanned "
            "line and does not turn it, which distinguishes it from a jitter of the joints. It is never named for a sensor that takes no scans."
        ),
        cause=(
            "A scanner that is not yet warm, a mount or cable that gives a little between scans, vibration, or a surface whose speckle or roughness "
            "differs from scan to scan."
        ),
        how_sure=(
            f"{_COMMON_RULE} Where a jitter of the joints explains the scatter nearly as well, `confounded_with` names it, and further poses near "
            "and far from the base separate the two."
        ),
        advice=(
            f"If its confidence is below {SURE:g}, or it is confounded with a jitter: {REPEAT_POSES[:1].lower()}{REPEAT_POSES[1:]}",
            f"Otherwise: {SEVERAL_SCANS[:1].lower()}{SEVERAL_SCANS[1:].format(measurement='scan')}",
        ),
        in_picture="The scatter is as wide on the left as on the right: it does not depend on the lever of the joints.",
    ),
}
"""By the name under which diagnosis.json lists the random error."""
