"""Write a corrected dataset.yaml for the user if the table of joints contradicts the data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import pi
from pathlib import Path
from typing import Any

from scalar.errors import Fault

CORRECTED = "corrected-dataset.yaml"
_ROUNDING = 1e-12  # m or rad: what conversions between conventions leave


@contextmanager
def corrected_description(dataset: Path, output: Path) -> Iterator[None]:
    """Write ``corrected-dataset.yaml`` to the output folder if the code inside raises ``WrongSetup`` about the table of joints.

    The corrected table has the convention of dataset.yaml, standard or modified DH, unless the correction is that of the convention. What the
    correction leaves alone stays as it is written there.

    Args:
        dataset: The folder of the dataset.
        output: The folder of the results, which exists.
    """
    from scalar.data.description import DESCRIPTION
    from scalar.data.io.plain_yaml import dump_yaml, load_yaml
    from scalar.estimation.setup.suspicion import WrongSetup
    from scalar.geometry.standard_dh import stated_mapping

    try:
        yield
    except WrongSetup as refusal:
        robot = refusal.suspicions[0].robot
        if robot is not None:
            path = output / CORRECTED
            described = load_yaml(dataset / DESCRIPTION)
            dump_yaml(
                {**described, "robot": corrected_block(described["robot"], stated_mapping(robot))}, path
            )
            offer = (
                f"written: dataset.yaml with the table of joints corrected{' for the first of these suspicions' if len(refusal.faults) > 1 else ''}; "
                "if it is right, look at the limits of the joints that it changes, and put it in the place of dataset.yaml"
            )
            refusal.faults = (*refusal.faults, Fault(str(path), offer))
        raise


def corrected_block(described: Mapping[str, Any], corrected: Mapping[str, Any]) -> dict[str, Any]:
    """Return the ``robot:`` block of a dataset with what a corrected block has otherwise, and everything else as it is written there.

    Args:
        described: The block of dataset.yaml.
        corrected: The complete block of the corrected arm.
    """
    transforms = {
        key: _clean(corrected[key])
        for key in ("base", "flange")
        if not _same_numbers(described.get(key, {}), corrected[key])
    }
    joints = [
        _corrected_row(row, new) for row, new in zip(described["joints"], corrected["joints"], strict=True)
    ]
    return {**described, "convention": corrected["convention"], "joints": joints, **transforms}


def _corrected_row(row: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of the table of joints; numbers that agree up to rounding and whole turns stay as they are written."""
    written = dict(row)
    for key in ("a", "alpha", "d", "theta", "beta"):
        value, was = float(new.get(key, 0.0)), float(row.get(key, 0.0))
        off = value - was if key in ("a", "d") else (value - was + pi) % (2.0 * pi) - pi
        if abs(off) > _ROUNDING:
            written[key] = _clean(value)
    if "limits" in row and any(
        abs(a - b) > _ROUNDING for a, b in zip(row["limits"], new["limits"], strict=True)
    ):
        written["limits"] = new["limits"]
    return written


def _same_numbers(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Return whether two fixed transforms agree up to rounding; what is not stated is zero."""
    zero = [0.0, 0.0, 0.0]
    return all(
        abs(float(a) - float(b)) <= _ROUNDING
        for key in ("translation", "rotation_vector")
        for a, b in zip(one.get(key, zero), other.get(key, zero), strict=True)
    )


def _clean(value: Any) -> Any:
    """Return a number, or all numbers of a transform, with zero in the place of rounding errors."""
    if isinstance(value, Mapping):
        return {key: [_clean(x) for x in numbers] for key, numbers in value.items()}
    return 0.0 if abs(value) <= _ROUNDING else float(value)
