"""What the hunt tries: every effect of the catalogue at every place of a robot, a sensor and its plates."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scalar.effects.base import BaseCompliance
from scalar.effects.catalogue import (
    MAX_ORDER,
    backlash_driver,
    drift_driver,
    plane_centre,
    range_middle,
)
from scalar.effects.effect import Effect
from scalar.effects.gravity import typical_masses, typical_torque
from scalar.effects.joints import (
    JointBacklash,
    JointCompliance,
    JointCoupling,
    JointHarmonic,
    JointScale,
)
from scalar.effects.links import AxisNonparallel, ThermalDrift
from scalar.effects.sensor import RangeDistortion, RangeOffset, RangeScale
from scalar.effects.surface import PlaneBow, PlaneMoved
from scalar.effects.unattributed import (
    GRAVITY,
    WAVE_STEP,
    UnattributedJoint,
    UnattributedLink,
    UnattributedSensor,
    UnattributedShape,
    UnattributedSway,
    UnattributedWave,
    Variable,
)
from scalar.geometry.parallel_axes import near_parallel_joints
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

HARMONIC_ORDERS = range(1, MAX_ORDER + 1)
BUMP_WIDTHS = (0.08, 0.16, 0.32)  # of half the range that a joint goes through
PLATEAU_WIDTHS = (0.12, 0.3)
STEP_WIDTHS = (0.03, 0.15)
KINK_WIDTH = 0.08
WAVE_ORDERS = (1.5, 33.5)  # periods a turn
SWAY_PERIODS = [k / 2 for k in range(1, 21)]  # in the whole acquisition
LEAST_TORQUE = (
    0.01  # of the most loaded joint's: below it the sign of a torque says nothing of where a joint rests
)
CREEP_STARTS = 12  # moments, spread over the whole order, from which a creep that is tried begins
CREEP_SHARES = (0.1, 0.3, 1.0)  # of the whole order: how long it takes, or to the end if that comes before
WARM_UP_SHARES = (0.1, 0.3, 1.0)  # of the whole time: time constants of a warm-up that are tried


@dataclass(frozen=True)
class CandidateEffect:
    """An effect to try, in one or several terms of which some may suffice.

    Attributes:
        effect: With all its terms.
        terms: Number of terms; more than one where only some may be needed (compliance: a frame's
            moments each; harmonics: an order each).
    """

    effect: Effect
    terms: int = 1

    def elements(self) -> list[Effect]:
        """Return the effects of a term each that stand, one after the other, for all columns of the effect."""
        return [self.effect] if self.terms == 1 else [self.with_terms([i]) for i in range(self.terms)]

    def with_terms(self, chosen: list[int]) -> Effect:
        """Return the effect with some of its terms only, in their own order."""
        if self.terms == 1:
            return self.effect
        chosen = sorted(chosen)
        if isinstance(self.effect, JointCompliance):
            return JointCompliance(tuple(self.effect.terms[i] for i in chosen))
        if isinstance(self.effect, JointHarmonic):
            return JointHarmonic(self.effect.joint, tuple(self.effect.orders[i] for i in chosen))
        assert isinstance(self.effect, BaseCompliance)
        return BaseCompliance(tuple(self.effect.frames[i] for i in chosen), self.effect.alike)


def candidates(dataset: Dataset, still: float) -> list[CandidateEffect]:
    """Return what can be tried on a dataset; change points are tried apart, at every moment (``scalar.diagnosis.score_test``)."""
    n = dataset.robot.n_joints
    moving = [j for j in range(1, n + 1) if np.ptp(dataset.q[:, j - 1]) > still]
    pairs = [(j, f) for j in moving for f in range(j, n + 1)]
    found = [
        CandidateEffect(JointCompliance(tuple(p for p in pairs if p[0] == j)), n + 1 - j) for j in moving
    ]
    found.append(CandidateEffect(JointCompliance(tuple(pairs)), len(pairs)))
    found += [CandidateEffect(BaseCompliance(tuple(range(1, n + 1)), alike), n) for alike in (True, False)]
    found += [CandidateEffect(JointHarmonic(j, (k,))) for j in moving for k in HARMONIC_ORDERS]
    found += [CandidateEffect(JointHarmonic(j, tuple(HARMONIC_ORDERS)), len(HARMONIC_ORDERS)) for j in moving]
    found += [CandidateEffect(JointScale(j)) for j in moving]
    found += [CandidateEffect(JointCoupling(j, s)) for j in moving for s in moving if s != j]
    found += [CandidateEffect(effect) for effect in _backlashes(dataset, moving)]
    found += [CandidateEffect(AxisNonparallel(j)) for j in near_parallel_joints(dataset.robot)]
    found += [CandidateEffect(effect) for effect in _drifts(dataset)]
    kind = kind_of(dataset)
    if kind.measures_range:
        found += [
            CandidateEffect(RangeScale()),
            CandidateEffect(RangeOffset()),
            CandidateEffect(RangeDistortion(range_middle(dataset))),
        ]
    if kind.scans:
        used = {dataset.planes[k].name for k in dataset.plane_index}
        found += [
            CandidateEffect(PlaneBow(p.name, plane_centre(dataset, p.name)))
            for p in dataset.planes
            if p.name in used
        ]
    found += [CandidateEffect(effect) for effect in _creeps(dataset)]
    return found


def _backlashes(dataset: Dataset, moving: list[int]) -> list[Effect]:
    """Return backlash of every joint whose side of its play is known: recorded, or pressed there by a torque worth the name."""
    torque = {j: np.max(np.abs(typical_torque(dataset.robot, dataset.q, j))) for j in moving}
    most = max(torque.values(), default=0.0)
    found: list[Effect] = []
    for j in moving:
        by = backlash_driver(dataset, j)
        if by == "approach":
            found.append(JointBacklash(j, by))
        elif torque[j] > LEAST_TORQUE * most:
            masses = typical_masses(dataset.robot, dataset.q, j)
            found.append(JointBacklash(j, by, tuple(float(m) for m in masses)))
    return found


def _creeps(dataset: Dataset) -> list[Effect]:
    """Return plates that creep from some moment on, to the end of the acquisition or until they have settled."""
    if not dataset.planes:
        return []
    order, time = _acquisition(dataset)
    found: list[Effect] = []
    for k in np.unique(dataset.plane_index):
        name = dataset.planes[k].name
        mine = np.flatnonzero(dataset.plane_index == k)
        span, end = float(np.ptp(order[mine])), float(order[mine[-1]])
        if span <= 0:
            continue
        centre = plane_centre(dataset, name)
        starts = np.unique(
            np.searchsorted(order[mine], order[mine[0]] + span * np.arange(CREEP_STARTS) / CREEP_STARTS)
        )
        for i in mine[starts]:
            start, at = float(order[i]), None if time is None else float(time[i])
            spans = {min(share * span, end - start) for share in CREEP_SHARES}
            found += [PlaneMoved(name, start, at, centre, creep) for creep in sorted(spans) if creep > 0]
    return found


def _acquisition(dataset: Dataset) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the order of acquisition ``(N,)`` and the time ``(N,)`` [s], or None where it is not recorded."""
    poses = dataset.poses
    order = (
        poses["order"].to_numpy(dtype=float) if "order" in poses else np.arange(dataset.n_poses, dtype=float)
    )
    return order, poses["time"].to_numpy(dtype=float) if "time" in poses else None


def _drifts(dataset: Dataset) -> list[Effect]:
    by = drift_driver(dataset)
    found: list[Effect] = []
    # A thermometer in the room does not feel the motors: an arm warms up by its own work as well, with the clock or from pose to pose.
    drivers = {by, "time" if "time" in dataset.poses else "order"}
    for driver in sorted(drivers):
        x = (
            dataset.poses[driver].to_numpy(dtype=float)
            if driver in dataset.poses
            else np.arange(dataset.n_poses)
        )
        start, span = float(np.min(x)), float(np.ptp(x))
        if span <= 0:
            continue
        last = start + span if driver == "order" else None
        found.append(ThermalDrift(driver, start, last=last))
        if driver != "temperature":
            found += [ThermalDrift(driver, start, share * span, last) for share in WARM_UP_SHARES]
    return found


def _places(width: float) -> list[float]:
    """Return places about two widths apart, within the range of a variable."""
    return [float(at) for at in np.linspace(-1, 1, round(1 / width) + 2)[1:-1]]


def _shapes(joint: int, angle: Variable) -> list[Effect]:
    """Return bumps, steps, kinks and powers of a joint's error along its own angle."""
    kinds = [("bump", width, width / 2) for width in BUMP_WIDTHS]
    kinds += [("plateau", width, width / 2) for width in PLATEAU_WIDTHS]
    kinds += [("step", width, width) for width in STEP_WIDTHS]
    kinds.append(("kink", KINK_WIDTH, KINK_WIDTH))
    found: list[Effect] = [UnattributedShape(joint, (angle,), shape) for shape in ("square", "cube")]
    return found + [
        UnattributedShape(joint, (angle,), shape, at, width)
        for shape, width, apart in kinds
        for at in _places(apart)
    ]


def curves(dataset: Dataset, joint: int) -> list[CandidateEffect]:
    """Return simple shapes of a joint's error along its own angle."""
    return [
        CandidateEffect(shape)
        for shape in _shapes(joint, Variable.seen(f"q{joint}", dataset.q[:, joint - 1]))
    ]


def waves(dataset: Dataset, joint: int) -> list[CandidateEffect]:
    """Return periodic errors of a joint in its own angle that are not whole parts of its turn: rivals of its harmonics."""
    angle = Variable.seen(f"q{joint}", dataset.q[:, joint - 1])
    orders = np.arange(*WAVE_ORDERS, WAVE_STEP)
    return [CandidateEffect(UnattributedWave(joint, (angle,), float(order))) for order in orders]


def flexible(dataset: Dataset, still: float) -> list[CandidateEffect]:
    """Return flexible terms that have no name: what is tried on structure that the named effects leave."""
    n = dataset.robot.n_joints
    moving = [j for j in range(1, n + 1) if np.ptp(dataset.q[:, j - 1]) > still]
    angles = {j: Variable.seen(f"q{j}", dataset.q[:, j - 1]) for j in moving}
    turns = kind_of(dataset).observes_orientation
    found: list[Effect] = [UnattributedJoint(j, (angles[v],)) for j in moving for v in moving]
    found += [
        UnattributedJoint(j, (angles[a], angles[b]))
        for j in moving
        for a, b in itertools.combinations(moving, 2)
    ]
    found += [
        UnattributedLink(j, by)
        for j in range(1, n + 1)
        for by in (f"q{j}", GRAVITY)
        if by == GRAVITY or j in moving
    ]
    found.append(UnattributedSensor(Variable(GRAVITY, 0.0, 1.0), turns))
    found += [shape for j in moving for shape in _shapes(j, angles[j])]
    found += [
        UnattributedShape(j, (angles[a], angles[b]), "product")
        for j in moving
        for a, b in itertools.combinations(moving, 2)
    ]
    order, time = _acquisition(dataset)
    drivers = {"order": order}
    for name in ("time", "temperature", *dataset.covariates):
        if name in dataset.poses and len(np.unique(dataset.poses[name].to_numpy())) > 4:
            drivers[name] = dataset.poses[name].to_numpy(dtype=float)
    for name, values in drivers.items():
        variable = Variable.seen(name, values)
        found.append(UnattributedSensor(variable, turns))
        found += [UnattributedJoint(j, (variable,)) for j in moving]
    course = Variable.seen("order", order) if time is None else Variable.seen("time", time)
    for j in moving:
        found.append(UnattributedShape(j, (course,), "line"))
        found += [
            UnattributedShape(j, (course,), "step", at, STEP_WIDTHS[0]) for at in _places(STEP_WIDTHS[0])
        ]
    found += [UnattributedSway(course, periods, turns) for periods in SWAY_PERIODS]
    return [CandidateEffect(effect) for effect in found]
