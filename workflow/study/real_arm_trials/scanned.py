"""Simulate campaigns of a line scanner on an arm among three target planes: scenes of ``configs/scenes``, by the simulator as it is."""

from __future__ import annotations

from pathlib import Path

from scalar.evaluate import true_frames
from study.common.in_memory import dataset_in_memory
from study.real_arm_trials.campaign import Campaign, config_of
from study.real_arm_trials.design import Trial

PLANES = 3
MARGIN_M = 0.05  # scans keep this far from the edges of their plane, so that no effect moves them off it


def scanned_campaign(trial: Trial, root: Path) -> Campaign:
    """Return the campaign of a set with a scanner; unseen poses are those of the arm at the end of the run, over all of its joints' ranges.

    Args:
        trial: The set.
        root: Folder from which the paths of scenes start.

    Raises:
        SimulationError: Too few postures see a target plane, or an effect moves a scan off it.
    """
    from scalar.simulation.scene import simulate

    scene = root / f"configs/scenes/{trial.robot}.yaml"
    config = config_of(
        trial,
        root,
        poses_per_plane=trial.poses // PLANES,
        noise={"range_noise_std_m": trial.noise_m, "joint_noise_std_rad": trial.repeatability_rad},
        edge_margin_m=MARGIN_M,
        truth_poses=trial.unseen,
    )
    config["sensor"] |= {"selection": "even", "points_per_scan": 100, "state_noise": trial.states_noise}
    simulated = simulate(config, base_dir=scene.parent)
    return Campaign(
        dataset_in_memory(simulated),
        simulated.truth["effects"],
        simulated.truth_poses,
        true_frames(simulated.truth_poses),
    )
