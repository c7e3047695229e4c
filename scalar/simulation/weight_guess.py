"""A guess of the masses and centres of mass of an arm's links, which makers do not state.

Each link is guessed from its piece of skeleton: a housing of `HOUSING` per metre and a drive of `DRIVE`, both lighter towards the
wrist. The centre of mass is half-way along the skeleton, plus a small random offset. Three arms of configs/robots come to 37, 32 and
27 kg this way, and their data sheets state 33.5, 18 and 27. A config may state all of these.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from scalar.simulation.arm import Arm
from scalar.simulation.transforms import Array
from scalar.simulation.weights import Weights

HOUSING = 12.0  # kg/m of skeleton, before the taper
DRIVE = 3.0  # kg for each link, before the taper
TAPER = (1.3, 0.5)  # factor of the first link's mass and of the last's
OFFSET = 0.02  # m; standard deviation of each coordinate of a centre of mass


def draw_weights(arm: Arm, block: Mapping[str, Any], rng: np.random.Generator) -> Weights:
    """Return the weights of the config's `masses` block, with guesses for what it leaves out."""
    n = arm.n
    ends = [np.array([arm.a[i + 1], 0.0, 0.0]) for i in range(n - 1)] + [arm.T_n_flange[:3, 3]]
    tips = [arm.joint_origin(i + 1)[:3, 3] for i in range(n - 1)] + [arm.T_n_flange[:3, 3]]
    lengths = np.array([_norm(e) + _norm(t - e) for e, t in zip(ends, tips, strict=True)])
    middles = [
        (_norm(e) * e / 2 + _norm(t - e) * (e + t) / 2) / max(_norm(e) + _norm(t - e), 1e-9)
        for e, t in zip(ends, tips, strict=True)
    ]
    masses = np.linspace(*TAPER, n) * (HOUSING * lengths + DRIVE)
    centres = np.array(middles) + OFFSET * rng.standard_normal((n, 3))
    if block["links_kg"] is not None:
        masses = np.array(block["links_kg"], float)
    if block["centres_m"] is not None:
        centres = np.array(block["centres_m"], float)
    return Weights(masses, centres, float(block["sensor_kg"]))


def _norm(vector: Array) -> float:
    return float(np.linalg.norm(vector))
