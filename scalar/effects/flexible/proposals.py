"""The flexible terms that are proposed for a dataset, to describe structure that the named effects do not explain."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from scalar.effects.acquisition import moving_joints, order_and_time, swept_joints, turning_joints
from scalar.effects.effect import Effect
from scalar.effects.flexible.growth import UnattributedGrowth
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.link import UnattributedLink
from scalar.effects.flexible.measured_space import ENCODER_ORDERS, UnattributedSpace
from scalar.effects.flexible.rivals_of_changes import changes_of_parts
from scalar.effects.flexible.sensor import UnattributedSensor
from scalar.effects.flexible.shape import UnattributedShape
from scalar.effects.flexible.sway import UnattributedSway
from scalar.effects.flexible.tilt import tilts
from scalar.effects.flexible.variable import GRAVITY, Variable
from scalar.effects.flexible.wander import COMPONENTS, UnattributedWander
from scalar.effects.flexible.wave import N_WAVES, WAVE_STEP, UnattributedWave
from scalar.effects.flexible.wobble import wobbles_of
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

# In units of half the measured range of the variable, as are the widths below.
BUMP_WIDTHS = (0.08, 0.16, 0.32)
PLATEAU_WIDTHS = (0.12, 0.3)
STEP_WIDTHS = (0.03, 0.15)
BEND_WIDTH = 0.08
WAVE_ORDERS = (1.5, 33.5)  # first order, and end (excluded), in periods per turn
SWAY_PERIODS = [k / 2 for k in range(1, 21)]  # numbers of periods of a sway in the whole acquisition
MOST_LABELS = 4  # a column with at most so many different values is taken for a label, not for a variable


def flexible_terms(dataset: Dataset) -> list[Effect]:
    """Return every flexible term that is tried on a dataset."""
    moving = moving_joints(dataset)
    angles = {j: Variable.observed(f"q{j}", dataset.q[:, j - 1]) for j in moving}
    pairs = [(j, a, b) for j in moving for a, b in itertools.combinations(moving, 2)]
    slides = {j: bool(dataset.robot.slides[j - 1]) for j in moving}
    swept = swept_joints(dataset)
    found: list[Effect] = [
        UnattributedJoint(j, (angles[v],), slides=slides[j]) for j in moving for v in swept
    ]
    found += [UnattributedJoint(j, (angles[a], angles[b]), slides=slides[j]) for j, a, b in pairs]
    found += [
        UnattributedLink(j, by)
        for j in range(1, dataset.robot.n_joints + 1)
        for by in (f"q{j}", GRAVITY)
        if by == GRAVITY or j in moving
    ]
    found += tilts(dataset)
    found += wobbles_of(turning_joints(dataset))
    found.append(UnattributedSensor(Variable(GRAVITY, 0.0, 1.0), kind_of(dataset).shows_turns(dataset)))
    found += [shape for j in swept for shape in _shapes(j, angles[j], slides[j])]
    found += [wave for j in turning_joints(dataset) if j in swept for wave in waves_of(dataset, j, 1)]
    found += [UnattributedShape(j, (angles[a], angles[b]), "product", slides=slides[j]) for j, a, b in pairs]
    return found + _in_time(dataset, moving)


def _in_time(dataset: Dataset, moving: list[int]) -> list[Effect]:
    """Return terms that vary with order, time, temperature, or any further column of poses.csv."""
    turns = kind_of(dataset).shows_turns(dataset)
    order, time = order_and_time(dataset)
    drivers: dict[str, Array] = {"order": order}
    for name in ("time", "temperature", *dataset.covariates):
        if name in dataset.poses and len(np.unique(dataset.poses[name].to_numpy())) > MOST_LABELS:
            drivers[name] = dataset.poses[name].to_numpy(dtype=float)
    found: list[Effect] = []
    for name, values in drivers.items():
        variable = Variable.observed(name, values)
        found.append(UnattributedSensor(variable, turns))
        found += [UnattributedJoint(j, (variable,), slides=bool(dataset.robot.slides[j - 1])) for j in moving]
    clock = Variable.observed("order", order) if time is None else Variable.observed("time", time)
    grows_with = [clock]
    if "temperature" in drivers:
        grows_with.append(Variable.observed("temperature", drivers["temperature"]))
    found += [UnattributedGrowth(j, v) for j in range(1, dataset.robot.n_joints + 1) for v in grows_with]
    found += changes_of_parts(dataset)
    for j in moving:
        slides = bool(dataset.robot.slides[j - 1])
        found.append(UnattributedShape(j, (clock,), "line", slides=slides))
        found += [
            UnattributedShape(j, (clock,), "step", at, STEP_WIDTHS[0], slides=slides)
            for at in _places(STEP_WIDTHS[0])
        ]
    wandering = COMPONENTS if turns else COMPONENTS[3:]
    found += [UnattributedWander(clock, component) for component in wandering]
    return found + [UnattributedSway(clock, periods, turns) for periods in SWAY_PERIODS]


def errors_of_instrument(dataset: Dataset) -> list[UnattributedSpace]:
    """Return the distortions of the measured space that are tried if an instrument measures positions, else none."""
    if not kind_of(dataset).measures_positions:
        return []
    low, high = dataset.points.min(axis=0), dataset.points.max(axis=0)
    x, y, z = ((low + high) / 2).tolist()
    half = max(float(np.max(high - low)) / 2, 1e-3)
    maps = [UnattributedSpace(shape, 0, (x, y, z), half) for shape in ("strain", "quadratic")]
    return maps + [
        UnattributedSpace(s, k, (x, y, z), half) for s in ("azimuth", "elevation") for k in ENCODER_ORDERS
    ]


def curves_of(dataset: Dataset, joint: int) -> list[Effect]:
    """Return bumps, plateaus, steps, bends and powers of a joint's error along its own angle, for a joint that turns."""
    return _shapes(joint, Variable.observed(f"q{joint}", dataset.q[:, joint - 1]))


def waves_of(dataset: Dataset, joint: int, waves: int = N_WAVES) -> list[Effect]:
    """Return periodic errors of a joint in its own angle, each a sum of ``waves`` waves; their orders need not be whole numbers of periods a turn."""
    angle = Variable.observed(f"q{joint}", dataset.q[:, joint - 1])
    orders = np.arange(*WAVE_ORDERS, WAVE_STEP)
    return [UnattributedWave(joint, (angle,), float(order), waves) for order in orders]


def _places(width: float) -> list[float]:
    """Return places about two widths apart, within the range -1..1 of a variable."""
    return [float(at) for at in np.linspace(-1, 1, round(1 / width) + 2)[1:-1]]


def _shapes(joint: int, angle: Variable, slides: bool = False) -> list[Effect]:
    """Return bumps, plateaus, steps, bends and powers of a joint's error along its own angle or travel."""
    kinds = [("bump", width, width / 2) for width in BUMP_WIDTHS]
    kinds += [("plateau", width, width / 2) for width in PLATEAU_WIDTHS]
    kinds += [("step", width, width) for width in STEP_WIDTHS]
    kinds.append(("bend", BEND_WIDTH, BEND_WIDTH))
    found: list[Effect] = [
        UnattributedShape(joint, (angle,), shape, slides=slides) for shape in ("square", "cube")
    ]
    return found + [
        UnattributedShape(joint, (angle,), shape, at, width, slides=slides)
        for shape, width, apart in kinds
        for at in _places(apart)
    ]
