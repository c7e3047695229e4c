"""The thresholds of the correction of joint angles."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CorrectionSettings:
    """Thresholds of the correction.

    Attributes:
        position: [m] distance to the wanted place below which it is reached. Chosen: a hundredth of what the best arms
            repeat to; the iteration stops there.
        orientation: [rad] likewise; at a lever of a metre it is as far as ``position``.
        steps: Most steps of the first, fast iteration. Two or three are usual; what takes more is left for the damped one.
        jacobians: Number of steps of the fast iteration after which the Jacobian is computed anew; later steps keep it. Chosen: one costs
            least, since a later step then leaves less than a hundredth of the error, which is what harmonics of high order add to the Jacobian.
        damped_steps: Most steps of the damped iteration for what is left, with a Jacobian of its own at each.
        near_singular: Smallest singular value of the Jacobian (lengths in units of the arm's) below which a pose is called near a
            singularity. Chosen: an error of a milliradian then takes 50 mrad of a joint.
        largest_correction: [rad; m of a travel] change of a joint beyond which the correction of joint angles is refused. Chosen: arms err by some
            milliradians, and half a radian is another posture.
        damping: First damping of the damped iteration, relative to the squared Jacobian. Chosen; it is adapted tenfold at each step.
        orientation_weight: Weight of the orientation where there are fewer than six joints, so that the place is met and the
            orientation as far as it may be. Chosen: what cannot be met of the orientation, some milliradians, then moves the place by
            about 1e-9 m.
        chunk: Poses that are computed together: their arrays stay in the processor's cache.
    """

    position: float = 1e-7
    orientation: float = 1e-7
    steps: int = 4
    jacobians: int = 1
    damped_steps: int = 40
    near_singular: float = 0.02
    largest_correction: float = 0.5
    damping: float = 1e-6
    orientation_weight: float = 1e-4
    chunk: int = 2000
