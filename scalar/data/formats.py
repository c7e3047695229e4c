"""Versions of the dataset's format: which are read, which is written, and what the newest adds.

Version 1 keeps every numeric column that it does not know, as a covariate. Version 2 gives some of these names a meaning: commanded
joint positions (``qc1..qcn``), which may be used in place of those logged; joint torques and the payload, which are covariates. Whatever
version 2 defines and this release does not use is refused, since ignoring it would give a wrong answer.
"""

from __future__ import annotations

DATASET_FORMAT = "scalar-dataset/2"
"""The version that is written."""

COMMANDED, TORQUE = "qc", "tau"
"""Columns of poses.csv, one for each joint: the commanded position [rad, m] and the torque [N m, N]."""
PAYLOAD = ("payload", "payload_x", "payload_y", "payload_z")
"""Columns of poses.csv: the payload's mass [kg], and where it sits in the flange's frame [m]."""
ORIENTATION = ("rx", "ry", "rz")
"""Columns of points.csv where orientations were measured: the rotation vector from the target's axes to the tracker's [rad]."""
TARGET_MOTION = tuple(f"target_motion_{axis}" for axis in ("rx", "ry", "rz", "x", "y", "z"))
"""Columns that measurements of reference nests add to each pose: the motion of the base relative to the tracker, a screw in the base
frame [rad, m]."""
IMPORTED = "imported"
"""The key of dataset.yaml, and of a calibration's summary, with what an import knew: the ``mapping``, ``joints`` if it converted joints, and how, and
``order`` if nothing stated the order of the poses."""
FEW_PLANES = "few_planes"
"""The key of dataset.yaml, and of a calibration's summary, that says ``true`` if there are no more planes: what these do not show is then left to the
data sheet. Without it, fewer than three planes, and planes whose normals span only two directions, are refused."""
NOT_STATED = "not stated"
