"""Everything that reads a file: where its good files come from, which of them are damaged, and how they are read."""

from __future__ import annotations

import hashlib
import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scalar.data.io.json_reader import read_json
from scalar.data.io.plain_yaml import load_yaml
from tests.endurance import binary_files, foreign_files, own_files, used_files
from tests.endurance.mutations import mutated


@dataclass(frozen=True)
class Reader:
    """One thing that reads files.

    Attributes:
        name: What it reads.
        make: Writes good files to an empty folder.
        read: Reads the files of a folder, and returns what was read as plain data or text.
        damaged: Patterns of the names of the files to damage.
        content: Parses one file to plain data. A damaged file that parses to the same data as the good one has to be read alike.
            None: this is not compared.
        damage: Returns the bytes of a file with things wrong in them.
    """

    name: str
    make: Callable[[Path], None]
    read: Callable[[Path], Any]
    damaged: tuple[str, ...] = ("*",)
    content: Callable[[Path], Any] | None = None
    damage: Callable[[bytes, random.Random], bytes] = mutated


def answer(value: Any) -> str:
    """Return a checksum of what a reader returned."""
    return hashlib.sha256(repr(value).encode(errors="surrogatepass")).hexdigest()


READERS = {
    reader.name: reader
    for reader in (
        Reader("dataset of scans", own_files.dataset_writer("line-laser"), own_files.read_dataset_folder),
        Reader("dataset of a probe", own_files.dataset_writer("probe"), own_files.read_dataset_folder),
        Reader("dataset of a tracker", own_files.dataset_writer("tracker"), own_files.read_dataset_folder),
        Reader(
            "dataset in Parquet",
            own_files.dataset_writer("line-laser", "parquet"),
            own_files.read_dataset_folder,
            ("*.parquet",),
        ),
        Reader(
            "calibration",
            own_files.write_calibration_file,
            own_files.read_calibration_file,
            content=read_json,
        ),
        Reader("diagnosis", own_files.write_diagnosis_file, own_files.read_diagnosis_file, content=read_json),
        Reader("scene", own_files.write_scene_files, own_files.read_scene_files, content=load_yaml),
        Reader("config and grids", own_files.write_config_files, own_files.read_config_files),
        Reader("mapping and table", foreign_files.write_mapping_files, foreign_files.read_mapping_files),
        Reader("URDF", foreign_files.write_urdf_file, foreign_files.read_urdf_file),
        Reader("DH table", foreign_files.write_dh_file, foreign_files.read_dh_file),
        Reader(
            "joints, by the command", own_files.write_joints_file, own_files.read_joints_file, ("joints.csv",)
        ),
        Reader("truth", own_files.write_truth_folder, own_files.read_truth_folder),
        Reader(
            "truth, evaluated", used_files.write_truth_to_use, used_files.evaluate_by_truth, ("truth.json",)
        ),
        Reader(
            "spreadsheet",
            binary_files.write_spreadsheet,
            binary_files.importer("table.xlsx"),
            ("*.xlsx",),
            damage=binary_files.mutated_within,
        ),
        Reader("matrix of MATLAB", binary_files.write_matrix, binary_files.importer("table.mat"), ("*.mat",)),
        Reader("bag", foreign_files.write_bag_file, foreign_files.read_bag_file),
        Reader("dataset with all of version 2", used_files.write_campaign, used_files.read_campaign),
        Reader("dataset, calibrated", used_files.write_campaign, used_files.calibrate_campaign),
        Reader(
            "bag, imported",
            used_files.write_recording,
            used_files.import_recording,
            ("*.bag",),
            damage=used_files.with_other_numbers,
        ),
        Reader(
            "calibration, used",
            used_files.write_calibration_to_use,
            used_files.use_calibration,
            ("calibration.json",),
            content=read_json,
        ),
        Reader(
            "whole diagnosis",
            used_files.write_whole_diagnosis,
            used_files.read_whole_diagnosis,
            content=read_json,
        ),
        Reader(
            "result of a batch", used_files.write_batch_result, used_files.read_batch_result, ("batch.json",)
        ),
    )
}
