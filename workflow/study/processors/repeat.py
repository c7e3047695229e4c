"""Repeat calibrations and their evaluation with the arithmetic of another processor, in a process of its own.

The simulation is not repeated, since its measured points are the same bytes with all kernels.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from study.processors.kernels import environment, imitates


def repeat_on(
    kernels: str, case: str, data_dirs: Sequence[str | Path], methods: Sequence[str], out: str | Path
) -> None:
    """Write errors.csv of all seeds and methods, calibrated and evaluated in a process with the kernels of a processor.

    Args:
        kernels: A key of ``KERNELS``.
        case: Name of the datasets' case.
        data_dirs: Folders of simulated datasets, one for each batch, as ``simulate_seeds`` wrote them.
        methods: Keys of ``study.common.methods.METHODS``.
        out: The table to write, columns ``study.headline.evaluate.ERROR_COLUMNS``.

    Raises:
        RuntimeError: This machine cannot run the kernels.
        subprocess.CalledProcessError: The process failed.
    """
    if not imitates(kernels):
        raise RuntimeError(
            f"this machine cannot calculate with the kernels of {kernels}; SkylakeX's need a processor with AVX-512"
        )
    command = [
        sys.executable,
        "-m",
        "study.processors.repeat",
        case,
        ",".join(methods),
        str(out),
        *map(str, data_dirs),
    ]
    print(f"{kernels}: {len(methods)} methods", flush=True)
    subprocess.run(command, env=environment(kernels), check=True, stdout=sys.stdout, stderr=sys.stderr)


def _repeat(case: str, methods: Sequence[str], out: str, data_dirs: Sequence[str]) -> None:
    """Calibrate and evaluate in this process, whose environment has chosen the kernels."""
    from study.common.tables import write_table
    from study.headline.calibrate import calibrate_seeds
    from study.headline.evaluate import evaluate_seeds

    tables = []
    for data in data_dirs:
        with tempfile.TemporaryDirectory(prefix="processors-") as folder:
            calibrations = {method: f"{folder}/{method}" for method in methods}
            for method, place in calibrations.items():
                calibrate_seeds(data, method, place)
            tables.append(evaluate_seeds(case, data, calibrations).errors)
    write_table(out, pd.concat(tables, ignore_index=True), digits=17)


if __name__ == "__main__":
    case_name, names, table_path, *folders = sys.argv[1:]
    _repeat(case_name, names.split(","), table_path, folders)
