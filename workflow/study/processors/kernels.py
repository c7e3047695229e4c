"""Imitate the arithmetic of other processors on one machine.

NumPy and SciPy each contain OpenBLAS, which chooses kernels (inner loops) made for the processor on which it runs, and NumPy has loops
of its own for processors with wider registers. Kernels add in different orders, so results differ in their last bits. Two environment
variables change the choice: ``OPENBLAS_CORETYPE`` names the kernels of both OpenBLAS libraries, and ``NPY_DISABLE_CPU_FEATURES`` lists
the registers that NumPy's loops may not use.

A machine without AVX-512 cannot imitate ``SkylakeX``. Processors that are not x86 and other builds of BLAS are not imitated.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from typing import Any

OPENBLAS, NUMPY = "OPENBLAS_CORETYPE", "NPY_DISABLE_CPU_FEATURES"


@dataclass(frozen=True)
class Kernels:
    """The arithmetic of a processor.

    Attributes:
        names: The names that OpenBLAS may report for the kernels that it then runs. The wheels of NumPy and SciPy do not contain kernels for every
            processor; OpenBLAS then runs, and reports, those of a similar one.
        avx2: Whether NumPy may use AVX2 registers.
        avx512: Whether NumPy may use AVX-512 registers.
    """

    names: frozenset[str]
    avx2: bool
    avx512: bool


KERNELS = {
    "Prescott": Kernels(frozenset({"Prescott", "Katmai"}), avx2=False, avx512=False),
    "Haswell": Kernels(frozenset({"Haswell"}), avx2=True, avx512=False),
    "SkylakeX": Kernels(frozenset({"SkylakeX"}), avx2=True, avx512=True),
    "Zen": Kernels(frozenset({"Zen", "Haswell"}), avx2=True, avx512=False),
}
"""``{value of OPENBLAS_CORETYPE: arithmetic}``."""


def environment(kernels: str) -> dict[str, str]:
    """Return the environment variables with which a process calculates as on another processor, a key of ``KERNELS``."""
    wanted = KERNELS[kernels]
    import numpy as np

    config: Any = np.show_config("dicts")
    forbidden = [
        feature
        for feature in config["SIMD Extensions"].get("found", [])
        if not (wanted.avx512 if _is_avx512(feature) else wanted.avx2)
    ]
    return os.environ | {OPENBLAS: kernels, NUMPY: " ".join(forbidden)}


def _is_avx512(feature: str) -> bool:
    return feature.startswith("AVX512") or feature == "X86_V4"


REPORT = """
import numpy as np
from study.processors.kernels import kernels_in_use
square = np.ones((300, 300))
square @ square
print(*kernels_in_use())
"""
"""OpenBLAS accepts kernels that the processor cannot run, and reports them; only a product shows that it cannot."""


def kernels_taken(kernels: str) -> set[str]:
    """Return the names of the kernels that run in a process made for a processor, a key of ``KERNELS``; none if this machine cannot run them.

    Raises:
        subprocess.CalledProcessError: The process failed for another reason.
    """
    ran = subprocess.run(
        [sys.executable, "-c", REPORT], env=environment(kernels), capture_output=True, text=True, check=False
    )
    if ran.returncode == -signal.SIGILL:
        return set()
    ran.check_returncode()
    return set(ran.stdout.split())


def imitates(kernels: str) -> bool:
    """Return whether this machine calculates as another processor, a key of ``KERNELS``, when asked to."""
    taken = kernels_taken(kernels)
    return bool(taken) and taken <= KERNELS[kernels].names


def kernels_in_use() -> set[str]:
    """Return the names of the kernels that the OpenBLAS libraries of this process run."""
    import scipy.linalg  # noqa: F401  # loads SciPy's OpenBLAS, so that it is found as well as NumPy's
    from threadpoolctl import threadpool_info  # imported here: installed with the workflow alone

    return {library["architecture"] for library in threadpool_info() if library["internal_api"] == "openblas"}
