"""Read the content of a calibration file, and refuse what is no calibration or is damaged, naming the key."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar, cast

from scalar.data.io.json_reader import read_json
from scalar.data.io.run_id import DIAGNOSIS_FILES, check_run
from scalar.errors import Fault, InvalidInput
from scalar.estimation.calibration_file import check_calibration

FORMAT = "scalar-calibration/2"
VERSION_1 = "scalar-calibration/1"
"""Is still read but no longer written. It nests the names of the free parameters and their covariance matrix under ``covariance``."""
KEYS = frozenset(
    {"format", "run", "robot", "sensor", "parameters", "gauge", "effects", "residual_rms_m", "planes", "tracker_frames", "summary"}
    | {"names", "covariance", "target", "targets", "noise"}
)  # fmt: skip
_TABLES = frozenset({".csv", ".tsv", ".txt", ".xlsx"})
_IN_A_FOLDER = ("calibration.json", "after.json")  # what the commands write into the folder given as --output
PARAMETER_KEYS = frozenset({"value", "std", "unit", "held", "reason", "prior"})

_Built = TypeVar("_Built")


def read_calibration(path: Path, build: Callable[[Mapping[str, Any]], _Built]) -> _Built:
    """Return what ``build`` makes of the content of a calibration file, which is first brought to the present version of the format.

    Args:
        path: The calibration file.
        build: Called with the checked content.

    Raises:
        InvalidInput: The file is missing, is not JSON, is damaged (the key is named), is not a calibration, or has an effect whose
            module is absent.
    """
    if not path.exists():
        command = "diagnose" if path.name in DIAGNOSIS_FILES else "calibrate"
        raise InvalidInput(Fault(str(path), f"no such file; 'scalar {command} DATASET -o DIR' writes one"))
    inside = [path / name for name in _IN_A_FOLDER if (path / name).is_file()]
    if inside:
        raise InvalidInput(Fault(str(path), f"a folder, not a calibration; give {inside[0]}"))
    if path.is_dir() and (path / "dataset.yaml").is_file():
        advice = f"calibrate it first ('scalar calibrate {path} -o DIR') and give DIR/calibration.json"
        raise InvalidInput(Fault(str(path), f"a dataset, not a calibration; {advice}"))
    if path.suffix.lower() in _TABLES:
        raise InvalidInput(
            Fault(str(path), "a table, where a calibration is expected; the calibration comes first")
        )
    check_run(path)
    content: Any = read_json(path)
    if not isinstance(content, dict) or content.get("format") not in (VERSION_1, FORMAT):
        wrong = f"not a calibration: its format is not '{FORMAT}'"
        if isinstance(content, dict) and str(content.get("format")).startswith("scalar-diagnosis/"):
            wrong = (
                "a diagnosis, not a calibration; give the after.json (or the before.json) in the same folder"
            )
        raise InvalidInput(Fault(str(path), wrong, None, "format"))
    try:
        mapping = _as_version_2(cast(dict[str, Any], content))
        check_calibration(mapping, str(path))
        unknown = [key for key in mapping if key not in KEYS]
        unknown += [
            f"parameters.{name}.{key}"
            for name, entry in mapping["parameters"].items()
            for key in entry
            if key not in PARAMETER_KEYS
        ]
        if unknown:  # to ignore what a later release wrote would give a wrong answer
            message = "not known to this release of scalar; use the release that wrote the file"
            raise InvalidInput([Fault(str(path), message, None, key) for key in unknown])
        return build(mapping)
    except InvalidInput as error:  # the fault of an effect of unknown kind does not name the file
        raise InvalidInput([replace(fault, file=str(path)) for fault in error.faults]) from None
    except (KeyError, TypeError, ValueError, IndexError, OverflowError, AttributeError) as error:
        damage = f"damaged calibration: {type(error).__name__} {error}"
        raise InvalidInput(Fault(str(path), damage)) from None


def _as_version_2(mapping: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the content of a calibration of either version as that of version 2."""
    nested = mapping.get("covariance")
    if mapping["format"] == FORMAT or not isinstance(nested, dict):
        return mapping
    return {**mapping, "format": FORMAT, "names": nested.get("names"), "covariance": nested.get("matrix")}
