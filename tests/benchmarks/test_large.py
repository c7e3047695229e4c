"""The large scenes err as they say, the peak of a command is its own, and a fleet has the damage that it states."""

import sys

import numpy as np
import pytest

from benchmarks import large
from benchmarks.fleet import write_fleet
from benchmarks.peak import peak_command, peak_memory
from benchmarks.seeds import datasets
from scalar.data.dataset import read_dataset
from scalar.errors import InvalidInput
from tests.random_scene import make_scene


@pytest.mark.parametrize(
    "make, robot, orders, curve",
    [(large.tracked, "vs060", {5: 3e-4}, 0.0), (large.worst, "panda", large.ORDERS, large.CURVE)],
)
def test_a_scene_errs_as_it_says(make, robot, orders, curve):
    """The true angles follow from those that are read by the stated errors."""
    true = make_scene(robot, "tracker", seed=1, poses_per_plane=10, noise=large.NOISE).dataset.q
    read = make(30).dataset.q
    expected = read.copy()
    expected[:, 1] += sum(size * np.sin(order * read[:, 1]) for order, size in orders.items())
    expected[:, 3] *= 1 + 1e-3
    expected[:, 5] += curve * np.tanh(3.0 * read[:, 0] * read[:, 2])
    assert np.allclose(expected, true, rtol=0, atol=1e-12)


def test_the_peak_is_that_of_the_command():
    """A command with a large array has a larger peak than one without, whatever this process holds; its exit status is kept."""
    status, small = peak_command([sys.executable, "-c", "pass"])
    assert status == 0
    assert peak_memory([sys.executable, "-c", "b'1' * 200_000_000"]) - small > 150_000_000
    assert peak_command([sys.executable, "-c", "raise SystemExit(3)"])[0] == 3
    with pytest.raises(RuntimeError, match="ended with 3"):
        peak_memory([sys.executable, "-c", "raise SystemExit(3)"])


def test_one_folder_in_ten_is_damaged(tmp_path):
    """Of thirty campaigns three are refused, each for another damage."""
    write_fleet(tmp_path, 30)
    faults = []
    for folder in sorted(tmp_path.iterdir()):
        try:
            read_dataset(folder)
        except InvalidInput as error:
            faults.append((folder.name, str(error)))
    assert [name for name, _ in faults] == ["arm-00009", "arm-00019", "arm-00029"]
    assert len({text.replace(name, "") for name, text in faults}) == 3


def test_seeds_of_one_configuration_differ():
    """Each seed has data of its own, with the same number of poses."""
    first, second = datasets([1, 2])
    assert first.n_poses == second.n_poses
    assert not np.array_equal(first.points, second.points)
