"""Whether a fit ended where a real arm can be: links, zeros and the sensor's place near the data sheet, noise near what is stated."""

from __future__ import annotations

import numpy as np

from scalar.data.covariates import misspelt_columns
from scalar.data.dataset import Dataset
from scalar.data.motion import still_in_words, still_joints
from scalar.data.record_units import RECORDS, units_suspected
from scalar.data.rounding import rounded_angles, rounded_points
from scalar.estimation.model import Model
from scalar.estimation.outlying_points import scatter_about_lines
from scalar.estimation.setup.arm.lengths import ROBOT, SIGMAS, lengths_off
from scalar.estimation.setup.planes.known_planes import contradictions
from scalar.estimation.setup.planes.plane_guesses import far_guesses
from scalar.estimation.setup.planes.wrongly_known_planes import known_names, with_and_without
from scalar.estimation.setup.sensor.nearer_target import nearer_target
from scalar.estimation.setup.sensor.scan_axes import misread_axes
from scalar.estimation.setup.suspicion import Suspicion
from scalar.estimation.setup.tables.approach_signs import opposite_approach
from scalar.estimation.setup.tables.computed_positions import computed
from scalar.estimation.setup.tables.copies import copied_poses, repeated_readings
from scalar.estimation.setup.tables.stuck_joint import stands_still_for_long
from scalar.geometry.angles import within_half_turn
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.se3 import Array, log_so3
from scalar.robots import doubt_of_name, largest_payload
from scalar.sensors import Target, kind_of
from scalar.units import DEG, MM

ZERO = 5 * DEG  # a joint zero that was set by marks is wrong by a few degrees at most
SENSOR_TURN = 45 * DEG  # from the stated pose, which may be wrong by 30 degrees
SENSOR_SHIFT = 150 * MM  # from the stated pose
OFF_AXIS = 20 * MM  # from the axis of the last joint: nearer to it, the side of the sensor says nothing
AROUND = 75 * DEG  # about that axis, from where it is stated: a mount drawn roughly is on the right side
DISAGREEMENT = 5 * DEG  # of measured orientations, from pose to pose: no tracker measures them so poorly
QUIET = 0.5  # ratio of the residual to what the stated noise explains: with a smaller one, the noise is said to be stated wrongly
FAR_BELOW = 0.2  # ratio of the scatter within scans to the stated noise: with a smaller one, the noise is said to be stated too large
ROUNDED = 1.15  # ratio of the residual to what the stated noise explains: with a larger one, joint angles may be rounded
ROUNDED_ANGLES = "rounded_angles"
KNOWN_PLANE = "known_plane"  # as a suspicion names one that is not where it is declared known
LOUD = 3.0  # ratio of the scatter within scans to the stated noise: with a larger one, the noise is said to be stated wrongly, or points to stray


def implausible(
    dataset: Dataset,
    model: Model,
    std: Array,
    *,
    guess: Target,
    rotation_observed: bool,
    residual: float,
    misfit_ratio: float | None = None,
    rotation_noise: float = 0.0,
    fixed_length: str | None = None,
) -> tuple[Suspicion, ...]:
    """Return what is suspect in the description of the set-up, judged by a fit that explains the data.

    Args:
        dataset: What was measured.
        model: Where the fit ended.
        std: ``(P,)``, standard errors in the order of ``model.names``; NaN for what is fixed.
        guess: The target at its initial guess.
        rotation_observed: Whether the data of this kind of sensor depend on its orientation on the flange.
        residual: Root mean square of what the fit leaves [m].
        misfit_ratio: The residual over what the stated noise explains, or None where none is stated.
        rotation_noise: Standard deviation [rad] of measured orientations as the fit leaves it; 0 where none were measured or it is stated.
        fixed_length: Name of the length to which all others are relative because the data show no length; None if they show it.
    """
    found = [
        *_known_planes(dataset, model),
        *lengths_off(dataset, model, std, fixed_length),
        *_zeros(dataset, model, std),
        *_sensor(dataset, model, rotation_observed),
        *(Suspicion("plane_guess", name, sentence) for name, sentence in far_guesses(dataset, model, guess)),
    ]
    rounding = _rounding(dataset, residual, misfit_ratio)
    if not any(suspicion.what == ROBOT for suspicion in found) and (doubt := doubt_of_name(dataset.robot)):
        found.append(Suspicion(ROBOT, "robot.name", doubt))
    return (
        *found,
        *_orientations(rotation_noise),
        *_stated_noise(misfit_ratio),
        *computed(dataset, residual, rounded=any(one.what == ROUNDED_ANGLES for one in rounding)),
        *_scatter(dataset),
        *rounding,
        *_columns(dataset),
        *_motion(dataset),
    )


def _known_planes(dataset: Dataset, model: Model) -> list[Suspicion]:
    """Return a suspicion for each known plane that came out elsewhere, or one if a fit without what is declared of them is clearly better."""
    found = [Suspicion(KNOWN_PLANE, c.plane, c.sentence) for c in contradictions(dataset, model)]
    compared = None if found else with_and_without(dataset, model)
    if compared is not None and compared.are_suspect:
        names = known_names(dataset)
        found.append(Suspicion(KNOWN_PLANE, ", ".join(names), compared.sentence(names)))
    return found


def _orientations(noise: float) -> list[Suspicion]:
    """Return a suspicion if the measured orientations disagree with the arm; ``noise`` is the standard deviation [rad] that the fit leaves."""
    if noise <= DISAGREEMENT:
        return []
    return [
        Suspicion(
            "orientation",
            "points.csv, rx,ry,rz",
            f"the measured orientations disagree with the arm's by {noise / DEG:.0f} degrees from pose to pose: rx,ry,rz have to be "
            "a rotation vector (the axis times the angle, in radians), and Euler angles have to be converted to it (by `scalar import`, if "
            "euler_axes of the mapping is right)",
        )
    ]


def _stated_noise(misfit_ratio: float | None) -> list[Suspicion]:
    """Return a suspicion if the residual is far smaller than the stated noise explains; ``misfit_ratio`` is None where no noise is stated."""
    if misfit_ratio is None or misfit_ratio >= QUIET:
        return []
    return [
        Suspicion(
            "noise",
            "sensor.noise",
            f"the residual is only {misfit_ratio:.2g} times what the stated noise explains: the noise is stated too large, "
            "or the lengths of the measurements are in another unit",
        )
    ]


def _rounding(dataset: Dataset, residual: float, misfit_ratio: float | None) -> list[Suspicion]:
    """Return a suspicion if the joint angles, and one if the measurements, are rounded so coarsely that this explains the residual [m]."""
    found: list[Suspicion] = []
    if misfit_ratio is None or misfit_ratio > ROUNDED:
        if rounded := rounded_angles(dataset.robot, dataset.q, residual):
            found.append(Suspicion(ROUNDED_ANGLES, "poses.csv", rounded))
    if rounded := rounded_points(dataset.points, residual):
        found.append(Suspicion("rounded_points", kind_of(dataset).format.measured_in, rounded))
    return found


def _columns(dataset: Dataset) -> list[Suspicion]:
    """Return a suspicion for each column of poses.csv whose name is probably misspelt, or whose numbers have probably another unit or sign."""
    records = {name: dataset.poses[name].to_numpy() for name in RECORDS if name in dataset.poses}
    told = [
        *misspelt_columns(list(dataset.poses.columns), dataset.robot.n_joints),
        *(f"poses.csv: {told}" for told in units_suspected(records, largest_payload(dataset.robot.name))),
        *filter(None, [opposite_approach(dataset), stands_still_for_long(dataset)]),
    ]
    return [Suspicion("column", "poses.csv", sentence) for sentence in told]


def _motion(dataset: Dataset) -> list[Suspicion]:
    """Return a suspicion if several joints stand still in all poses, one if poses are copies of others, and one if readings were repeated."""
    found: list[Suspicion] = []
    if len(still := still_joints(dataset.q)) > 1:
        sentence = f"{still_in_words(still)}: how the arm errs where they stand elsewhere is not known; measure poses in which all joints move"
        found.append(Suspicion("motion", "poses.csv", sentence))
    if copies := copied_poses(dataset):
        found.append(Suspicion("copies", "poses.csv", copies))
    if readings := repeated_readings(dataset):
        found.append(Suspicion("readings", "poses.csv", readings))
    return found


def _scatter(dataset: Dataset) -> list[Suspicion]:
    """Return a suspicion if the points of half of the scans scatter far more or far less about their own line than the stated noise explains.

    A noise stated too large hides what the model lacks. If only the noise is larger than stated, no harm is done, since it is estimated. But stray
    points, if they are the majority, cannot be distinguished from such noise, and if they lie to one side, they falsify the calibration.
    """
    noise, counts = dataset.sensor.noise, np.diff(dataset.starts)
    if noise is None or not kind_of(dataset).scans or counts.min() <= 2:
        return []
    ratio = float(np.median(scatter_about_lines(dataset))) / noise
    if ratio < FAR_BELOW:
        return [
            Suspicion(
                "noise",
                "sensor.noise",
                f"the points of half of the scans scatter only {ratio:.2g} times as much about their own line as the stated noise, or less: it is "
                "stated too large, or in another unit; the residual is compared with the stated noise, and what the model lacks may hide below it",
            )
        ]
    if ratio <= LOUD:
        return []
    return [
        Suspicion(
            "noise",
            "sensor.noise",
            f"the points of half of the scans scatter {ratio:.2g} times as much about their own line as the stated noise explains, or more: "
            "the noise is stated too small, or many of the points are stray, and then the calibration may err by as much",
        )
    ]


def _zeros(dataset: Dataset, model: Model, std: Array) -> list[Suspicion]:
    """Return a suspicion for each joint whose zero changed too much."""
    k = GEOMETRY.index("theta")
    errors = std[model.blocks["geometry"]].reshape(dataset.robot.geometry.shape)[k]
    change = model.robot.geometry[k] - dataset.robot.geometry[k]
    errors = np.where(dataset.robot.slides, np.nan, errors)  # theta of a joint that slides is no zero
    change = np.where(np.isfinite(errors), within_half_turn(change), 0.0)
    return [
        Suspicion(
            "joint_zero",
            f"joint {j + 1}",
            f"the zero of joint {j + 1} is off by {change[j] / DEG:.1f} degrees: correct theta of joint {j + 1} in dataset.yaml, "
            "or the zero of the encoder; if it cannot be so far off, check the sign of this joint and of its neighbours, and the order "
            "of their columns",
        )
        for j in np.flatnonzero((np.abs(change) > ZERO) & (np.abs(change) > SIGMAS * np.nan_to_num(errors)))
    ]


def _sensor(dataset: Dataset, model: Model, rotation_observed: bool) -> list[Suspicion]:
    """Return suspicions if the sensor is too far from its stated pose on the flange; none if no pose is stated."""
    T = dataset.sensor.T_flange_sensor
    if T is None:
        return []
    (what, turned), found = kind_of(dataset).on_flange, []
    shift = float(np.linalg.norm(model.T_flange_sensor[:3, 3] - T[:3, 3]))
    if another := nearer_target(model, T):
        found.append(_sensor_suspicion(another))
    elif shift > SENSOR_SHIFT:
        found.append(
            _sensor_suspicion(
                f"the {what} sits {shift / MM:.0f} mm from where nominal_pose has it: correct nominal_pose, or check whether "
                "one of the last joints counts the other way or has another zero"
            )
        )
    about_axis = 0.0 if rotation_observed or found else _turned_about_last_axis(dataset, model)
    if about_axis > AROUND:
        last = f"joint {dataset.robot.n_joints}"
        found.append(
            _sensor_suspicion(
                f"seen along the axis of {last}, the {what} sits on another side of it than nominal_pose has it, {about_axis / DEG:.0f} degrees "
                f"round: correct nominal_pose, or the zero or sign of {last} in dataset.yaml"
            )
        )
    turn = log_so3(T[:3, :3].T @ model.T_flange_sensor[:3, :3])
    angle = float(np.linalg.norm(turn))
    if rotation_observed and angle > SENSOR_TURN:
        axis = "xyz"[int(np.argmax(np.abs(turn)))]
        kind = kind_of(dataset)
        axes = None
        if kind.scans:
            axes = misread_axes(T[:3, :3], model.T_flange_sensor[:3, :3], kind.format.measured_in)
        found.append(
            _sensor_suspicion(
                f"the {what} sits turned by {angle / DEG:.0f} degrees, mostly about its {axis}, from where nominal_pose has it: "
                f"correct nominal_pose, or check whether {turned}{f'; {axes}' if axes else ''}"
            )
        )
    return found


def _turned_about_last_axis(dataset: Dataset, model: Model) -> float:
    """Return by what angle [rad] the sensor's place is turned about the axis of the last joint from its stated one; 0 if it is near that axis."""
    T = dataset.sensor.T_flange_sensor
    assert T is not None
    # Positions in the frame of the last joint, whose z axis is that of the joint.
    stated, found = (
        (robot.T_n_flange @ pose)[:2, 3]
        for robot, pose in ((dataset.robot, T), (model.robot, model.T_flange_sensor))
    )
    if min(np.linalg.norm(stated), np.linalg.norm(found)) < OFF_AXIS:
        return 0.0
    angle = np.arctan2(found[1], found[0]) - np.arctan2(stated[1], stated[0])
    return float(abs(within_half_turn(angle)))


def _sensor_suspicion(sentence: str) -> Suspicion:
    return Suspicion("sensor_pose", "sensor.nominal_pose", sentence)
