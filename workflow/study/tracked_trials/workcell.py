"""What the tracked trials assume of every arm and of its surroundings: the planes that a probe touches, and the joints in which causes act."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from study.blind_trials.stratified_design import checked_config

SCHEMA = Path(__file__).parent / "schemas/tracked_workcell.schema.json"
WORKCELL = Path(__file__).parents[3] / "configs/tracked_workcell.yaml"
_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class TouchedPlane:
    """A plane that the probe touches.

    Attributes:
        name: Name of the plane in the dataset.
        axis: Index of the axis of the base frame near which its normal lies.
        behind: Share of the planned positions of the tip that lie on the side from which the normal points away.
    """

    name: str
    axis: int
    behind: float


@dataclass(frozen=True)
class Workcell:
    """The planes and joints of the tracked trials; joints are counted from 1.

    Attributes:
        planes: The planes that a probe touches.
        joints: Joints of which one is drawn for a cause that acts in one joint.
        relative_compliance: ``{joint: its compliance relative to the size of an injected joint_compliance}``, of the joints that it has.
        coupled_joints: ``joint`` and ``source`` of an injected joint_coupling.
    """

    planes: tuple[TouchedPlane, ...]
    joints: tuple[int, ...]
    relative_compliance: Mapping[int, float]
    coupled_joints: Mapping[str, int]


@cache
def load_workcell(path: Path = WORKCELL) -> Workcell:
    """Return the workcell that a YAML file describes.

    Raises:
        InvalidInput: The file is at fault; every fault is listed.
    """
    content = checked_config(path, SCHEMA)
    coupled = content["coupled_joints"]
    return Workcell(
        planes=tuple(
            TouchedPlane(plane["name"], _AXES.index(plane["axis"]), plane["behind"])
            for plane in content["planes"]
        ),
        joints=tuple(content["joints"]),
        relative_compliance={one["joint"]: one["relative"] for one in content["compliant_joints"]},
        coupled_joints={"joint": coupled["joint"], "source": coupled["driven_by"]},
    )
