"""One machine imitates several processors, and what is compared between them is what the tables hold."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from study.common.methods import METHODS, PROPOSED
from study.headline.evaluate import ERROR_COLUMNS
from study.headline.summary import QUANTITIES
from study.paper.numbers import rounded
from study.processors import kernels
from study.processors.compare import COMPARED, compare_processors, processor_numbers, relative_range
from study.processors.kernels import KERNELS, environment, imitates
from study.processors.repeat import repeat_on

SUMMARY = Path(__file__).parents[3] / "paper/summaries/processors"
CHECKSUM = """
import hashlib, numpy as np, scipy.linalg
a = np.random.default_rng(0).standard_normal((300, 300))
print(hashlib.sha256((a @ a).tobytes() + np.exp(a).tobytes()).hexdigest())
"""


def checksum(name: str) -> str:
    """Return a checksum of the arithmetic of a process made for a processor."""
    ran = subprocess.run(
        [sys.executable, "-c", CHECKSUM], env=environment(name), capture_output=True, text=True, check=True
    )
    return ran.stdout


@pytest.mark.slow
def test_every_library_takes_the_kernels_that_are_asked_for():
    """NumPy's OpenBLAS and SciPy's both take the kernels, and the bits of the results differ.

    Kernels that the machine cannot run are left out; Prescott's, which any x86 can run, never are.
    """
    possible = {name: checksum(name) for name in KERNELS if imitates(name)}
    assert "Prescott" in possible
    if "Haswell" in possible:
        assert possible["Haswell"] != possible["Prescott"]
        assert possible["Haswell"] == possible["Zen"]
    if "SkylakeX" in possible:
        assert len(set(possible.values())) == 3


def test_kernels_that_the_processor_cannot_run_are_not_imitated(monkeypatch, tmp_path):
    """Kernels whose process dies of an instruction unknown to the processor are not imitated, and a repetition with them says why."""
    monkeypatch.setattr(kernels, "REPORT", "import os, signal; os.kill(os.getpid(), signal.SIGILL)")
    assert not imitates("SkylakeX")
    with pytest.raises(RuntimeError, match="AVX-512"):
        repeat_on("SkylakeX", "a", [tmp_path], [PROPOSED], tmp_path / "errors.csv")
    monkeypatch.setattr(kernels, "REPORT", "raise SystemExit(1)")
    with pytest.raises(subprocess.CalledProcessError):
        imitates("SkylakeX")


def errors(factor: np.ndarray, status: str = "converged") -> pd.DataFrame:
    """Return errors.csv of one method whose every quantity is 2 times a factor a seed ``(S,)``."""
    rows = [
        {"case": "a", "seed": seed, "method": PROPOSED, "status": status, "alignment": alignment}
        | dict.fromkeys(COMPARED, 2.0 * value if alignment == "raw" else 1.0 / value)
        for seed, value in enumerate(factor)
        for alignment in ("raw", "aligned")
    ]
    return pd.DataFrame(rows).reindex(columns=list(ERROR_COLUMNS))


def test_a_difference_is_the_range_over_the_mean():
    """A difference of 10 % in one of four seeds is 10 % of that seed, a quarter of it in the mean, and zero in the median seed.

    A status that differs is counted.
    """
    low, high = np.array([1.0, 1.0, 1.0, 0.95]), np.array([1.0, 1.0, 1.0, 1.05])
    tables = {"one": errors(low), "two": errors(high, "capped")}
    table = compare_processors(tables).set_index("quantity")
    assert set(table.index) == set(COMPARED)
    for quantity in COMPARED:
        row = table.loc[quantity]
        assert row["single_seed"] == pytest.approx(0.1)
        assert row["mean"] == pytest.approx(0.025)
        assert row["median_seed"] == 0.0
        assert (row["seeds"], row["seeds_differing"], row["status_differing"]) == (4, 1, 4)
    numbers = processor_numbers(tables, compare_processors(tables))
    assert (numbers["different"], numbers["seeds"]) == (2, 4)
    assert numbers["methods"][PROPOSED]["converged"] == 0
    assert {name.rsplit("_", 1)[0] for name in QUANTITIES} <= set(numbers["methods"][PROPOSED])


def test_the_same_results_do_not_differ():
    """Processors with the same kernels differ by exactly zero, even where errors are zero, and count as one."""
    factor = np.array([0.0, 1.0, 3.0])
    tables = {"one": errors(factor + 1.0), "two": errors(factor + 1.0)}
    compared = compare_processors(tables)
    assert (compared[["mean", "single_seed", "seeds_differing", "status_differing"]] == 0).all(axis=None)
    assert processor_numbers(tables, compared)["different"] == 1
    np.testing.assert_array_equal(relative_range(np.array([[0.0, 0.0], [1.0, 3.0]])), [0.0, 1.0])


def test_no_mean_of_the_committed_summary_changes_in_a_digit_that_is_printed():
    """For the headline's own methods, the means over the processors agree in three digits, one more than the text prints of ours.

    For the reading with the defaults of 2018 they do not.
    """
    table = pd.read_csv(SUMMARY / "differences.csv")
    same = [
        rounded(row["lowest_mean"], 3) == rounded(row["highest_mean"], 3)
        for row in table[table["quantity"].isin(QUANTITIES)].to_dict("records")
    ]
    chaotic = table[table["quantity"].isin(QUANTITIES)]["method"] == "baseline-abs-2018"
    assert set(table["method"]) == {method.name for method in METHODS.values()}
    assert all(np.array(same)[~chaotic]) and not any(np.array(same)[chaotic])
