"""Read the arm, the sensor and the planes to plan for: from a dataset folder, which may have no poses yet, or from the library of arms."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from scalar.errors import Fault, InvalidInput
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.data.declared import PlaneGuess, Sensor
    from scalar.estimation.result import Calibration
    from scalar.geometry.robot import Robot

# Offset of a tracker's target from the flange along x and along z [m]; assumed for an arm of the library and for that of a URDF.
_TARGET_OFFSET = 0.1


def read_plan_source(
    source: str, *, needs_data: bool, may_have_data: bool = False
) -> tuple[Robot, Sensor, tuple[PlaneGuess, ...], Dataset | None]:
    """Return the arm, the sensor, the planes, and the dataset (None unless it is needed, or may be used and is there).

    Args:
        source: A dataset folder, or the name of an arm of the library.
        needs_data: Whether the measured poses are needed as well.
        may_have_data: Whether they are used where the folder has them.

    Raises:
        InvalidInput: There is no such folder or arm, or the folder lacks what a plan needs.
    """
    from scalar.data.dataset import read_dataset

    dataset = None
    if Path(source).exists():
        if needs_data:
            try:
                dataset = read_dataset(source)
            except InvalidInput as error:
                message = "--after needs the folder of the dataset that was diagnosed, with its data"
                raise InvalidInput([*error.faults, Fault(source, message)]) from None
            robot, sensor, planes = dataset.robot, dataset.sensor, dataset.planes
        else:
            robot, sensor, planes = _described(Path(source))
            if may_have_data:
                with suppress(InvalidInput):  # an empty folder, or a description alone
                    dataset = read_dataset(source)
    elif needs_data:
        message = "no such folder; give the folder of the dataset that was diagnosed"
        raise InvalidInput(Fault(source, message))
    else:
        robot, sensor, planes = _of_library(source)
    return robot, sensor, planes, dataset


def refuse_other_than_one_robot(
    source: str | None, urdf: Path | None, base: str | None, tip: str | None
) -> None:
    """Raise InvalidInput unless one robot is named: by a folder or the library, or by a URDF.

    Args:
        source: A dataset folder, or the name of an arm of the library; None if neither is given.
        urdf, base, tip: A URDF, and its links at the base and at the flange.
    """
    from scalar.cli.options import refuse_links_without_urdf

    refuse_links_without_urdf(urdf, base, tip)
    if (source is None) == (urdf is None):
        said = "missing" if source is None else f"{source} and --urdf {urdf} are two robots"
        message = f"{said}; give a dataset folder, or the name of an arm of the library, or --urdf FILE"
        raise InvalidInput(Fault("ROBOT", message))


def source_of_urdf(
    urdf: Path, base: str | None, tip: str | None, *, needs_data: bool
) -> tuple[Robot, Sensor, list[str]]:
    """Return the arm of a URDF with a tracker's target on its flange, and lines on what the description leaves out.

    Args:
        urdf: The file.
        base, tip: Names of the links at the base and at the flange; None for the root and for the only last link.
        needs_data: Whether the measured poses are needed as well, which a URDF does not have.

    Raises:
        InvalidInput: The file is no URDF, has no serial chain between these links, or measured poses are needed.
    """
    from scalar.effects.wording import listed
    from scalar.ingest.urdf import chain_between, read_urdf, robot_of_chain

    if needs_data:
        message = "--after needs the folder of the dataset that was diagnosed; give it in the place of --urdf"
        raise InvalidInput(Fault(str(urdf), message))
    document = read_urdf(urdf)
    chain = chain_between(document, base, tip)
    without = [joint.name for joint in chain.moving if not joint.states_limits]
    remarks = (
        [
            f"  no limits stated: {listed(without)}; those of a whole turn or travel are assumed, so check the poses"
        ]
        if without
        else []
    )
    return robot_of_chain(document.name, chain)[0], _target_on_flange(), remarks


def with_place(sensor: Sensor, calibration: Calibration | None) -> Sensor:
    """Return the sensor with its pose on the flange; if dataset.yaml states none, with that of the calibration.

    Raises:
        InvalidInput: Neither has it.
    """
    if sensor.T_flange_sensor is not None:
        return sensor
    if calibration is not None:
        return replace(sensor, T_flange_sensor=calibration.model.T_flange_sensor)
    message = (
        "the key is missing; a plan needs to know where the sensor is, roughly: write it under sensor: as nominal_pose: "
        "{translation: [0.0, 0.0, 0.1], rotation_vector: [0.0, 0.0, 0.0]} with your numbers, flange to sensor [m, rad], or plan --near a calibration"
    )
    raise InvalidInput(Fault("dataset.yaml", message, None, "sensor.nominal_pose"))


def lines_on_poses_not_counted(source: str) -> list[str]:
    """Return one line if the folder for which a plan was made without its measured poses has some; else none."""
    from scalar.data.folder import POSES
    from scalar.data.io.regular_file import MAX_TABLE_BYTES, read_regular_file

    path = Path(source) / POSES
    lines = read_regular_file(path, MAX_TABLE_BYTES).splitlines() if path.is_file() else []
    rows = [line for line in lines if line.strip()]
    if len(rows) < 2:
        return []
    return [
        f"  the {len(rows) - 1} poses in {path} are not counted, and the planned ones are numbered from 1: a campaign of its own; for poses that add "
        "to those measured, give --near CALIBRATION"
    ]


def calibration_near(near: Path | None, after: Path | None, arm: Robot) -> Calibration | None:
    """Return the calibration to plan near: the one given as ``--near``, else ``after.json`` next to the diagnosis, else None."""
    from scalar.estimation.result import load_calibration
    from scalar.geometry.same_arm import difference_of_arms

    path = near or (None if after is None else after.parent / "after.json")
    if path is None:
        return None
    if near is None and not path.exists():
        message = "no such file; --after takes the calibration that lies in the folder of the diagnosis: put after.json there, or name it with --near"
        raise InvalidInput(Fault(str(path), message))
    calibration = load_calibration(path)
    if (difference := difference_of_arms(calibration.model.nominal, arm)) is not None:
        raise InvalidInput(Fault(str(path), f"{difference}; give a calibration of this arm"))
    return calibration


def with_noise(sensor: Sensor, option: float | None, calibration: Calibration | None) -> Sensor:
    """Return a sensor with a noise: that of ``--noise`` [mm], else as ``scalar.planning.sensor_noise`` says."""
    from scalar.planning import sensor_noise

    return (
        sensor_noise.with_noise(sensor, calibration) if option is None else replace(sensor, noise=option * MM)
    )


def line_on_assumed_noise(sensor: Sensor, option: float | None, calibration: Calibration | None) -> list[str]:
    """Return one line if nothing states the noise for which poses are planned: that it is assumed, and what such sensors have; arguments as above."""
    from scalar.sensors.registry import kind_named

    known = calibration is not None and calibration.summary.get("sigma_m") is not None
    if option is not None or sensor.noise is not None or known:
        return []
    assumed = with_noise(sensor, None, None).noise or 0.0
    usual = kind_named(sensor.kind).usual_noise
    of_kind = "" if usual is None else f" ({usual.words})"
    return [
        f"  the noise of {assumed / MM:g} mm is assumed, since none is stated{of_kind}: give --noise, state sensor.noise in dataset.yaml, or plan "
        "--near a calibration, which estimates it"
    ]


def _described(folder: Path) -> tuple[Robot, Sensor, tuple[PlaneGuess, ...]]:
    """Return the arm, the sensor and the planes of a ``dataset.yaml``, or of a folder that has one."""
    from scalar.data.declared import declared_parts
    from scalar.data.description import DESCRIPTION, Description, check_description
    from scalar.data.io.plain_yaml import load_yaml_lines

    path = folder / DESCRIPTION if folder.is_dir() else folder
    description = Description(*load_yaml_lines(path))
    check_description(description)
    if description.faults:
        raise InvalidInput(description.faults)
    return declared_parts(description.mapping)


def _of_library(name: str) -> tuple[Robot, Sensor, tuple[PlaneGuess, ...]]:
    """Return an arm of the library with a tracker's target on its flange, and no planes."""
    from scalar.geometry.robot import Robot
    from scalar.robots import read_arm

    try:
        arm = read_arm(name)
    except InvalidInput as error:
        message = error.faults[0].message
        raise InvalidInput(Fault(name, f"no such folder, and {message}")) from None
    return Robot.from_mapping(arm.mapping), _target_on_flange(), ()


def _target_on_flange() -> Sensor:
    """Return a tracker with its target at a usual place on the flange."""
    import numpy as np

    from scalar.data.declared import Sensor
    from scalar.data.sensor_formats import sensor_formats

    T = np.eye(4)
    T[0, 3] = T[2, 3] = _TARGET_OFFSET
    kind = next(kind for kind, format in sensor_formats().items() if not format.on_planes)
    return Sensor(kind, T)
