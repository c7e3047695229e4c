"""The convention in which a controller counts the joints, from the mapping with which its tables were imported."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from scalar.data.formats import TORQUE
from scalar.data.joint_convention import JointConvention
from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array
from scalar.ingest.converted_joints import formulas
from scalar.ingest.mapping import Column, MappingFile
from scalar.ingest.mapping_reader import load_mapping
from scalar.ingest.raw_table import Reference


def controller_joints(path: Path, robot: Mapping[str, Any]) -> JointConvention:
    """Return how the controller counts the joints whose columns a mapping converts.

    Args:
        path: The mapping file.
        robot: The ``robot:`` block, in SI, of the arm whose joints are converted. It stands in for that of the mapping if this states none.

    Raises:
        InvalidInput: The mapping is at fault or is for an arm with other joints, or its columns of joints cannot be inverted.
    """
    mapping = load_mapping(path, otherwise=robot)
    _refuse_other_joints(path.name, mapping, robot)
    joints = [mapping.poses.columns[f"q{i + 1}"] for i in range(mapping.description.n_joints)]
    own = _own_columns(joints)
    n = len(joints)
    matrix = np.zeros((n, n))
    for i, column in enumerate(joints):
        for reference, sign in ((column.reference, 1.0), column.second or (None, 0.0)):
            if reference is None:
                continue
            if reference not in own:
                done, key = ("added to", "plus") if column.minus is None else ("subtracted from", "minus")
                message = f"{reference!r} is {done} q{i + 1} and is the column of no joint, so that joints of the dataset cannot be converted"
                raise InvalidInput(Fault(path.name, message, column=f"poses.columns.q{i + 1}.{key}"))
            k = own[reference]
            if joints[k].unit != column.unit:
                message = f"{reference!r} is in {joints[k].unit} for q{k + 1} and in {column.unit} for q{i + 1}; correct one of the two"
                raise InvalidInput(Fault(path.name, message, column=f"poses.columns.q{i + 1}.unit"))
            matrix[i, k] += column.sign * sign
    if abs(np.linalg.det(matrix)) < 0.5:  # it is a whole number
        sums = ", ".join(formulas(mapping))
        message = f"the joints of the controller do not follow from those of the dataset ({sums}); correct the columns that plus and minus name"
        raise InvalidInput(Fault(path.name, message, column="poses.columns"))
    offset = np.array([float(column.to_si(column.offset)) for column in joints])
    signs = _signs(mapping, np.diag(matrix))
    return JointConvention(matrix, offset, signs, ", ".join(formulas(mapping)), path.name)


def _refuse_other_joints(file: str, mapping: MappingFile, robot: Mapping[str, Any]) -> None:
    """Refuse a mapping for an arm with another number of joints, or with others that slide.

    Raises:
        InvalidInput: It is for such an arm.
    """
    types = [joint.get("type", "revolute") for joint in robot["joints"]]
    theirs = [joint.get("type", "revolute") for joint in mapping.description.get("robot", "joints")]
    if len(theirs) != len(types):
        message = f"it is for an arm with {len(theirs)} joints, and this one has {len(types)}; give the mapping of this arm"
        raise InvalidInput(Fault(file, message))
    if theirs != types:
        first = next(i for i in range(len(types)) if theirs[i] != types[i])
        message = f"it is for an arm whose joint {first + 1} is {theirs[first]}, and here this joint is {types[first]}; give the mapping of this arm"
        raise InvalidInput(Fault(file, message))


def _own_columns(joints: list[Column]) -> dict[Reference, int]:
    """Return ``{column of the file: index of the joint that it shows}``.

    A column to which nothing is added shows its joint. Of two columns that are added or subtracted, the first shows the joint, or the second if the
    first shows another one.
    """
    own = {column.reference: i for i, column in enumerate(joints) if column.second is None}
    for i, column in enumerate(joints):
        if column.second is not None:
            reference = column.second[0] if column.reference in own else column.reference
            own.setdefault(reference, i)
    return own


def _signs(mapping: MappingFile, of_joints: Array) -> dict[str, float]:
    """Return ``{column: -1}`` of directions of approach and torques that count the other way: as the mapping says, else as their joint does."""
    signs = {}
    for i, of_joint in enumerate(of_joints):
        for name in (f"approach{i + 1}", f"{TORQUE}{i + 1}"):
            column = mapping.poses.columns.get(name)
            if (of_joint if column is None else column.sign) < 0.0:
                signs[name] = -1.0
    return signs
