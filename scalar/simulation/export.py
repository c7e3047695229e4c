"""Write a simulated scene as two folders: `dataset`, which a calibration reads, and `truth`, with which its result is compared."""

from pathlib import Path
from typing import Any

from scalar.data.dataset_writer import refuse_dataset, write_dataset
from scalar.data.io.atomic import atomic_directory, plain, write_json
from scalar.data.io.run_id import RUN, run_of, source_with_run
from scalar.simulation.scene import SimulatedScene


def write_scene(
    scene: SimulatedScene, out_dir: Path, *, table_format: str = "csv", force: bool = False
) -> None:
    """Write `out_dir/truth` and then `out_dir/dataset`, each whole or not at all, with the identifier of their run in both.

    Args:
        scene: the scene to write.
        out_dir: made if missing.
        table_format: "csv" or "parquet", format of the scans.
        force: whether a dataset that was changed, or written by hand, is replaced.

    Raises:
        InvalidInput: something else is in the way.
    """
    out_dir = Path(out_dir)
    refuse_dataset(out_dir / "dataset", force)
    truth: dict[str, Any] = plain(scene.truth)
    run = run_of(truth, plain(scene.dataset))
    with atomic_directory(out_dir / "truth", may_replace=_is_truth) as folder:
        write_json(folder / "truth.json", {**truth, RUN: run})
        scene.truth_poses.to_csv(folder / "truth_poses.csv", index=False, lineterminator="\n")
    write_dataset(
        out_dir / "dataset",
        mapping={**scene.dataset, "source": source_with_run(scene.dataset["source"], run)},
        poses=scene.poses,
        scans=scene.scans,
        force=force,
        table_format=table_format,  # pyright: ignore[reportArgumentType]
    )


def _is_truth(folder: Path) -> bool:
    """Return whether a folder has the files of a truth and no others, so that it may be replaced."""
    return {path.name for path in folder.iterdir()} == {"truth.json", "truth_poses.csv"}
