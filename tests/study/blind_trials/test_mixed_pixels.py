"""Scans that cross an edge have mixed pixels there, which are set aside; the poses themselves are good and stay."""

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("pybullet")
from study.blind_trials.stratified_design import load_design
from study.blind_trials.stratified_run import scenes
from study.common.in_memory import dataset_in_memory

from scalar.estimation.gross_errors import clean

ROOT = Path(__file__).parents[3]
SEEDS, POSES = 4, 60


@pytest.mark.parametrize("robot", ["vs060", "large_arm"])
@pytest.mark.parametrize(
    "edge_share", [None, 0.5, 1.0], ids=["as in the trials", "half of the scans", "all scans"]
)
def test_good_poses_with_mixed_pixels_stay(robot, edge_share):
    """Of 240 good poses of the trials' scanner with mixed pixels, fewer than 1 % are set aside or said to lie on another plane, however many of its
    scans cross an edge; mixed pixels, glints among them, are set aside as points."""
    design = load_design(ROOT / "configs/blind_trials_stratified.yaml")
    conditions = {"scanner": "mixed", "surface": "flat", "injected": "none", "poses": POSES, "robot": robot}
    lost = points = 0
    for number in range(SEEDS):
        trial = design.trial(number, conditions)
        more = {"truth_poses": 1} | ({} if edge_share is None else {"scanner.edge_share": edge_share})
        simulated, _ = scenes(design, replace(trial, overrides=trial.overrides | more), ROOT)
        cleaned = clean(dataset_in_memory(simulated))
        lost += len(cleaned.outlier_poses) + len(cleaned.mislabelled_poses)
        points += cleaned.points
    assert points > 0
    assert lost < 0.01 * SEEDS * POSES
