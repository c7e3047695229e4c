"""Calibrate the datasets of one case, a seed each, by one method; a fit that fails is recorded, and the others are still made."""

from __future__ import annotations

from pathlib import Path

from scalar.data.dataset import read_dataset
from scalar.data.io.atomic import write_json
from scalar.errors import NotConverged, Undetermined
from study.common.methods import CONVERGED, METHODS
from study.common.seeds import found_seeds

FAILURE_FORMAT = "scalar-failure/1"


def calibrate_seeds(data_dir: str | Path, method: str, out_dir: str | Path) -> None:
    """Write ``seed-001.json`` and so on: each contains a calibration, or the status and the reasons of a fit that failed.

    Args:
        data_dir: Folder of simulated datasets, as ``simulate_seeds`` wrote it.
        method: A key of ``study.common.methods.METHODS``.
        out_dir: Folder for the files; made if missing.
    """
    for seed, folder in found_seeds(data_dir):
        path = Path(out_dir) / f"{folder.name}.json"
        try:
            calibration = METHODS[method].calibrate(read_dataset(folder / "dataset"))
        except Undetermined as error:
            status = "not_converged" if isinstance(error, NotConverged) else "undetermined"
            write_json(path, {"format": FAILURE_FORMAT, "status": status, "reasons": list(error.reasons)})
            print(f"seed {seed}: {status}: {error}", flush=True)
            continue
        calibration.save(path)
        status = calibration.summary.get("status", CONVERGED)
        print(f"seed {seed}: {status}, {calibration.summary.get('evaluations')} evaluations", flush=True)
