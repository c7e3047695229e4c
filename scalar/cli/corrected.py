"""Write a corrected dataset.yaml for the user if the table of joints contradicts the data."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scalar.cli.terminal import say

CORRECTED = "corrected-dataset.yaml"


@contextmanager
def corrected_description(dataset: Path, output: Path) -> Iterator[None]:
    """Write ``corrected-dataset.yaml`` to the output folder if the code inside raises ``WrongSetup`` about the table of joints.

    The corrected table has the convention of dataset.yaml, standard or modified DH, unless the correction is that of the convention.

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
            dump_yaml({**load_yaml(dataset / DESCRIPTION), "robot": stated_mapping(robot)}, path)
            say(
                f"scalar: {path} is dataset.yaml with the table of joints corrected for the first of the suspicions below; "
                "if it is right, put it in the place of dataset.yaml",
                err=True,
            )
        raise
