"""Read the arm, the sensor and the planes to plan for: from a dataset folder, which may have no poses yet, or from the library of arms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from scalar.errors import Fault, InvalidInput
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.data.declared import PlaneGuess, Sensor
    from scalar.geometry.robot import Robot

_TARGET_OFFSET = (
    0.1  # m, of a tracker's target from the flange along x and along z, assumed for an arm of the library
)


def declared(
    source: str, noise: float | None, *, needs_data: bool
) -> tuple[Robot, Sensor, tuple[PlaneGuess, ...], Dataset | None]:
    """Return the arm, the sensor with its noise, the planes, and the dataset (None unless it is needed).

    Args:
        source: A dataset folder, or the name of an arm of the library.
        noise: Noise of the sensor [mm], instead of the declared one; or None.
        needs_data: Whether the measured poses are needed as well.

    Raises:
        InvalidInput: There is no such folder or arm, or the folder lacks what a plan needs.
    """
    from scalar.sensors.rows import stated_sigma

    dataset = None
    if Path(source).exists():
        if needs_data:
            from scalar.data.dataset import read_dataset

            try:
                dataset = read_dataset(source)
            except InvalidInput as error:
                message = "--after needs the folder of the dataset that was diagnosed, with its data"
                raise InvalidInput([*error.faults, Fault(source, message)]) from None
            robot, sensor, planes = dataset.robot, dataset.sensor, dataset.planes
        else:
            robot, sensor, planes = _described(Path(source))
        if sensor.T_flange_sensor is None:
            message = (
                "is missing; a plan needs to know where the sensor is, roughly: write it under sensor: as "
                "nominal_pose: {translation: [0.0, 0.0, 0.1], rotation_vector: [0.0, 0.0, 0.0]}, flange to sensor [m, rad]"
            )
            raise InvalidInput(Fault("dataset.yaml", message, None, "sensor.nominal_pose"))
    elif needs_data:
        message = "no such folder; give the folder of the dataset that was diagnosed"
        raise InvalidInput(Fault(source, message))
    else:
        robot, sensor, planes = _of_library(source)
    stated = stated_sigma(sensor.noise) if noise is None else noise * MM
    return robot, replace(sensor, noise=stated), planes, dataset


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
    import numpy as np

    from scalar.data.declared import Sensor
    from scalar.data.sensor_formats import sensor_formats
    from scalar.geometry.robot import Robot
    from scalar.robots import read_arm

    try:
        arm = read_arm(name)
    except InvalidInput as error:
        message = error.faults[0].message
        raise InvalidInput(Fault(name, f"no such folder, and {message}")) from None
    robot = Robot.from_mapping(arm.mapping)
    T = np.eye(4)
    T[0, 3] = T[2, 3] = _TARGET_OFFSET
    kind = next(kind for kind, format in sensor_formats().items() if not format.on_planes)
    return robot, Sensor(kind, T), ()
