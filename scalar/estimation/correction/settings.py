"""The thresholds of the correction of joint angles."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CorrectionSettings:
    """Thresholds of the correction.

    Attributes:
        position: [m] distance to the wanted place below which it counts as reached, and the iteration stops. Chosen: a hundredth of the
            repeatability of the best arms.
        orientation: [rad] the same for the orientation. With a lever of a metre it moves a point as far as ``position``.
        steps: Most steps of Newton's method. Two or three are usual; a pose that needs more is left to the damped iteration.
        jacobians: Number of steps of Newton's method after which the Jacobian is computed anew; later steps keep it. Chosen: with one, the run
            time is least. The Jacobian leaves out what effects add to it, at most a hundredth (harmonics of high order), so that each later step
            still divides the error by a hundred or more.
        damped_steps: Most steps of the damped iteration. Its Jacobian is computed anew at each step.
        near_singular: Smallest singular value of the Jacobian (lengths in units of the arm's) below which a pose is called near a
            singularity. Chosen: an error of a milliradian then takes 50 mrad of a joint.
        largest_correction: [rad; m of a travel] change of a joint beyond which the correction of joint angles is refused. Chosen: arms err by some
            milliradians, and half a radian is another posture.
        small_change: [rad; m of a travel] most by which a joint is changed where that does not reach the wanted frame exactly. Chosen: a straight
            elbow of an arm of a metre that bends by as much shortens the arm by a millimetre.
        near_enough: [m] distance from a wanted frame that the arm cannot take within which the nearest joint angles are still given. Chosen: an
            arm errs by as much before it is calibrated; one that misses by more is meant to be elsewhere.
        near_enough_turn: [rad] the same for the orientation. Chosen: three degrees, which a straight wrist may miss.
        most_turn_of_few_joints: [rad] error of the orientation up to which a frame counts as reached by an arm with fewer than six joints,
            which cannot take every orientation. Chosen: three degrees; a real arm misses by tenths of one what its data sheet reaches.
        damping: Initial damping of the damped iteration, relative to the squared Jacobian. Chosen: nearly none; each step multiplies or
            divides it by ten.
        orientation_weight: Weight of the orientation, relative to the position, for an arm with fewer than six joints, which can rarely meet
            both. Chosen: an orientation that is missed by some milliradians then shifts the position by about 1e-9 m.
        chunk: Poses that are computed together. Chosen: their arrays fit in the processor's cache.
    """

    position: float = 1e-7
    orientation: float = 1e-7
    steps: int = 4
    jacobians: int = 1
    damped_steps: int = 40
    near_singular: float = 0.02
    largest_correction: float = 0.5
    small_change: float = 0.1
    near_enough: float = 5e-3
    near_enough_turn: float = 0.05
    most_turn_of_few_joints: float = 0.05
    damping: float = 1e-6
    orientation_weight: float = 1e-4
    chunk: int = 2000
