"""Robot descriptions in URDF: a serial chain between two links as a robot in modified Denavit-Hartenberg parameters."""

from scalar.ingest.urdf.chain import Chain, ChainJoint, chain_between
from scalar.ingest.urdf.document import UrdfDocument, read_urdf
from scalar.ingest.urdf.to_robot import robot_from_urdf, robot_of_chain

__all__ = [
    "Chain",
    "ChainJoint",
    "UrdfDocument",
    "chain_between",
    "read_urdf",
    "robot_from_urdf",
    "robot_of_chain",
]
