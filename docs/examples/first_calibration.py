"""
Calibrate, and compare with the truth
=====================================

A workcell is simulated, so that the truth is known. The calibration reads the dataset alone.
"""

# %%
# The scene describes a six-joint arm with a line laser on its flange, among three planes. It is made smaller here, so that this page is built
# quickly. ``simulate`` gives the dataset as a user would have it, and the truth beside it.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import scalar
from scalar.evaluate import evaluate, read_truth
from scalar.simulation import load_config, simulate, write_scene

root = next(path for path in Path.cwd().parents if (path / "configs").exists())
config = load_config(root / "configs/scenes/paper.yaml")
config |= {"poses_per_plane": 20, "truth_poses": 1000}
folder = Path(tempfile.mkdtemp())
write_scene(simulate(config), folder)

dataset = scalar.read_dataset(folder / "dataset")
print(f"{dataset.n_poses} poses, {len(dataset.points)} laser points")

# %%
# One call calibrates. Each parameter has a standard error. What the data do not determine is fixed, each with its reason.

calibration = scalar.calibrate(dataset)
print(f"residual: {1000 * calibration.residual_rms:.3f} mm")
for name, reason in calibration.fixed.items():
    print(f"{name}: {reason}")

# %%
# The truth holds frames of the sensor at random poses, computed by the simulator. Planes do not determine the place of the robot's base, so the
# errors are also given after the best rigid motion of the base (*aligned*).

poses, truth = read_truth(folder / "truth", dataset.robot.n_joints)
after = evaluate(calibration, poses, truth)
before = evaluate(scalar.Calibration.nominal(dataset), poses, truth)
for name, found in (("before", before), ("after", after)):
    print(f"{name}: mean position error {1000 * found.aligned.position.mean():.3f} mm, aligned")

fig, ax = plt.subplots(figsize=(7, 3.2), layout="constrained")
bins = np.geomspace(1e-3, 50, 60)
for name, found in (("before", before), ("after", after)):
    ax.hist(1000 * found.aligned.position, bins, label=name, alpha=0.7)
ax.set_xscale("log")
ax.set_xlabel("position error [mm]")
ax.set_ylabel("poses")
ax.legend()

# %%
# The calibration's own standard errors say how large the errors should be. Over these poses they agree:

predicted = np.sqrt(np.mean(after.predicted_position_std**2))
found = np.sqrt(np.mean(after.raw.position**2))
print(f"position error: predicted {1000 * predicted:.3f} mm, found {1000 * found:.3f} mm (root mean square)")
