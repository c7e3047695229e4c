"""Offer a corrected dataset.yaml where the table of joints is what contradicts the data."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scalar.cli.terminal import say

CORRECTED = "corrected-dataset.yaml"


@contextmanager
def corrected_description(dataset: Path, output: Path) -> Iterator[None]:
    """Write ``corrected-dataset.yaml`` to the output folder if what is done inside refuses the table of joints.

    Args:
        dataset: The folder that is read.
        output: The folder that results go to; it exists.
    """
    from scalar.data.description import DESCRIPTION
    from scalar.data.io.plain_yaml import dump_yaml, load_yaml
    from scalar.estimation.setup.suspicion import WrongSetup

    try:
        yield
    except WrongSetup as refusal:
        robot = refusal.suspicions[0].robot
        if robot is not None:
            path = output / CORRECTED
            dump_yaml({**load_yaml(dataset / DESCRIPTION), "robot": robot.to_mapping()}, path)
            say(
                f"scalar: {path} is dataset.yaml with the table of joints corrected for the first of the suspicions below; "
                "if it is right, put it in the place of dataset.yaml",
                err=True,
            )
        raise
