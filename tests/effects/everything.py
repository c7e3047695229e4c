"""One of every effect, with coefficients of real sizes, and poses with every optional column."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.effects.acquisition import plane_centre
from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.effect import Effect
from scalar.effects.flexible.angle_sum import UnattributedAngleSum
from scalar.effects.flexible.arm_step import UnattributedArmStep
from scalar.effects.flexible.growth import UnattributedGrowth
from scalar.effects.flexible.incidence import UnattributedIncidence
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.link import UnattributedLink
from scalar.effects.flexible.load_step import UnattributedLoadStep
from scalar.effects.flexible.profile_bow import UnattributedProfileBow
from scalar.effects.flexible.profile_width import UnattributedProfileWidth
from scalar.effects.flexible.proposals import errors_of_instrument
from scalar.effects.flexible.sensor import UnattributedSensor
from scalar.effects.flexible.sensor_warm_up import UnattributedSensorWarmUp
from scalar.effects.flexible.shape import UnattributedShape
from scalar.effects.flexible.sway import UnattributedSway
from scalar.effects.flexible.tilt import UnattributedTilt
from scalar.effects.flexible.variable import GRAVITY, Variable
from scalar.effects.flexible.wander import UnattributedWander
from scalar.effects.flexible.wave import UnattributedWave
from scalar.effects.flexible.wind_up import UnattributedWindUp
from scalar.effects.flexible.wobble import UnattributedWobble
from scalar.effects.flexible.yielding import UnattributedYielding
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_coupling import JointCoupling
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_hysteresis import JointHysteresis
from scalar.effects.joint_ripple import JointRipple
from scalar.effects.joint_scale import JointScale
from scalar.effects.payload_deflection import PayloadDeflection
from scalar.effects.plane_bow import PlaneBow
from scalar.effects.plane_moved import PlaneMoved
from scalar.effects.pose_lag import PoseLag
from scalar.effects.range_distortion import RangeDistortion
from scalar.effects.range_offset import RangeOffset
from scalar.effects.range_scale import RangeScale
from scalar.effects.restarted_warm_up import RestartedWarmUp
from scalar.effects.sensor_map import SensorMap
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.target_drift import TargetDrift
from scalar.effects.thermal_drift import ThermalDrift
from scalar.effects.torque_compliance import TorqueCompliance

SIZE = {"rad": 3e-4, "m": 5e-4, "rad/rad": 1e-3, "m/m": 1e-3, "1/m": 5e-3}
SIZE |= {"1/K": 1e-5, "1/s": 1e-6, "1/pose": 3e-6, "1": 0.1, "rad/(N m)": 1e-5}


def optional_columns(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return time, temperature, approach1.. and a column of no known meaning."""
    time = np.cumsum(rng.uniform(5.0, 15.0, n_poses))
    columns = {"time": time, "temperature": 21.0 + 6.0 * (1 - np.exp(-time / 600.0))}
    columns |= {f"approach{j + 1}": rng.choice([-1.0, 1.0], n_poses) for j in range(n_joints)}
    columns |= {f"tau{j + 1}": rng.normal(0.0, 20.0, n_poses) for j in range(n_joints)}
    columns |= {"payload": rng.choice([0.0, 5.0], n_poses), "payload_z": np.full(n_poses, 0.1)}
    return columns | {"humidity": rng.uniform(30.0, 50.0, n_poses)}


def every_effect(dataset: Dataset, rng: np.random.Generator) -> list[Effect]:
    """Return one effect of every kind that a dataset can show, on six joints, coefficients random; errors of an instrument for a tracker alone."""
    q = {j: Variable.observed(f"q{j}", dataset.q[:, j - 1]) for j in (2, 5)}
    half = float(dataset.n_poses // 2)
    floor, wall = (plane_centre(dataset, name) for name in ("floor", "wall_x"))
    effects: list[Effect] = [
        JointCompliance(((2, 2), (2, 3), (3, 3), (5, 6))),
        JointHarmonic(4, (2,)),
        JointHarmonic(3, (1, 5, 32)),
        JointRipple(2, (40, 49)),
        JointScale(2),
        JointCoupling(6, 5),
        JointBacklash(2, "approach"),
        JointBacklash(3, "torque"),
        JointBacklash(4, "moves"),
        PoseLag(1),
        JointHysteresis(5, (0.2,)),
        JointHysteresis(2, (0.02, 0.6)),
        JointBacklash(2, "torque", (0.9, 0.1, 0.4, -0.2, 0.1, 0.0, 0.1, 0.0, 0.05, 0.0)),
        AxisNonparallel(3),
        BaseCompliance((2, 3)),
        ThermalDrift("temperature", 21.0),
        ThermalDrift("time", 0.0),
        ThermalDrift("time", 0.0, 400.0),
        ThermalDrift("time", 0.0, 400.0, about=1e-3),
        ThermalDrift("order", 0.0),
        RestartedWarmUp("time", (0.0, 100.0), (80.0, 400.0), 60.0),
        RestartedWarmUp("order", (0.0, half), (half - 1.0, 2.0 * half), half / 2, 0.0),
        TargetDrift("time", 0.0, 2e3, (1, 2)),
        TorqueCompliance((2, 3)),
        PayloadDeflection((2, 5)),
        TargetDrift("order", 0.0, 2.0 * half, (1,)),
        TargetDrift("step", order=half, moment=120.5),
        SensorSlip(half, 120.5),
        SensorSlip(half, None, turns=False),
        RangeScale(),
        RangeOffset(),
        RangeDistortion(),
        SensorMap((0.01, 0.3), (0.08, 0.12)),
        PlaneBow("floor", floor),
        PlaneMoved("wall_x", half, None, wall),
        PlaneMoved("floor", 3.0, 17.25, floor, creep_span=50.0),
        UnattributedJoint(3, (q[2],)),
        UnattributedJoint(3, (q[2], q[5])),
        UnattributedJoint(1, (Variable("humidity", 40.0, 10.0),)),
        *(
            UnattributedShape(2, (q[2],), shape, 0.2, 0.3)
            for shape in ("bump", "plateau", "step", "kink", "bend")
        ),
        *(UnattributedShape(4, (q[5],), shape) for shape in ("line", "square", "cube")),
        UnattributedShape(6, (q[2], q[5]), "product"),
        UnattributedWave(5, (q[5],), 7.3),
        UnattributedWave(5, (q[5],), 3.6, 1),
        UnattributedSway(Variable("time", 0.0, 1e4), 1.7),
        UnattributedSway(Variable("order", half, half), 3.2, turns=False),
        UnattributedWander(Variable("time", 0.0, 1e4), "rx"),
        UnattributedWander(Variable("order", half, half), "z"),
        UnattributedSensorWarmUp(Variable("time", 0.0, 1e4), "rx", 3e3),
        UnattributedSensorWarmUp(Variable("order", half, half), "z"),
        UnattributedGrowth(2, Variable("temperature", 25.0, 5.0)),
        UnattributedGrowth(5, Variable("order", half, half)),
        UnattributedArmStep((3,), Variable("order", half, half), 0.2),
        UnattributedArmStep((1, 2, 3, 4, 5, 6), Variable("order", half, half), -0.4),
        UnattributedLoadStep((2, 3, 5), Variable("order", half, half), 0.1),
        UnattributedProfileWidth(),
        UnattributedIncidence(),
        UnattributedProfileBow(0.1),
        UnattributedTilt(1),
        UnattributedTilt(3),
        UnattributedAngleSum(5, (4, 6), 1, 0.1, 2.5),
        UnattributedAngleSum(6, (4, 6), -1, 0.0, 2.5),
        UnattributedYielding(3, ((2, 3), (3, 4)), (4e-4, -2e-4, 6e-4, 1e-4), 2e-4),
        UnattributedWobble(4, 2),
        UnattributedLink(4, "q4"),
        UnattributedLink(3, GRAVITY),
        UnattributedSensor(Variable(GRAVITY, 0.0, 1.0)),
        UnattributedSensor(Variable("order", half, half), turns=False),
        UnattributedWindUp(3, 0.8),
        UnattributedWindUp(2, 0.5, (0.9, 0.1, 0.4, -0.2, 0.1, 0.0, 0.1, 0.0, 0.05, 0.0)),
        *errors_of_instrument(dataset),
    ]
    return [with_random_coefficients(effect, rng) for effect in effects]


def with_random_coefficients(effect: Effect, rng: np.random.Generator) -> Effect:
    """Return an effect with Gaussian coefficients of real sizes."""
    sizes = np.array([SIZE[unit] for unit in effect.coefficient_units])
    return effect.with_coefficients(sizes * rng.standard_normal(len(sizes)))


def describe(effect: Effect) -> str:
    """Return a short name for a test's title."""
    return f"{effect.key}-{len(effect.coefficients)}"
